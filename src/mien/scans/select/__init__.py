"""Which frames of a take to scan (Huang et al. 2011, sec. 4), and which of its markers could be spared."""
