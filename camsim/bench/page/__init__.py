"""The style and the script of the report, as files."""
