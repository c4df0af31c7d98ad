"""Who stands on the stage: a person outside the identity space, their skin and their way of moving."""
