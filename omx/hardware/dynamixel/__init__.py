"""The arm's servos: their control table, their units, their packets, and the bus they share."""
