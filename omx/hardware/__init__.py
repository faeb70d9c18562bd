"""The arm itself: servos on the wire, the virtual arm behind the same wire, the driver with its safety rules, logs."""
