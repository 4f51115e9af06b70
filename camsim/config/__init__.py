"""YAML files to stages: read with positions, validated by a schema, built into a camera and a scene."""
