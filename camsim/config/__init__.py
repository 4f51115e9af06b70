"""YAML files in, stages out: read with positions, judged by a schema, built into a camera and a scene."""
