"""The electronic stages, one file each; ``camsim.sensor.electronics`` lists them."""
