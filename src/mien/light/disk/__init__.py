"""Takes, scans and patterns as files."""
