def fetch():
    """x"""
    from ..errors import BadInput
    raise BadInput("nope")
