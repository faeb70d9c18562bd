"""Drives an arm with `rustypot`: argument 1 is the serial port. Prints what it saw, as JSON. No omx in here."""

import json
import sys
import time

from rustypot import Xl430PyController

ARM = [11, 12, 13, 14, 15]


def main(port):
    """Look around, move all joints, use indirect registers, reboot and reset a servo."""
    io = Xl430PyController(port, 1_000_000, 1.0)
    seen = {"pings": [io.ping(servo) for servo in ARM], "models": [io.read_register(s, "model_number") for s in ARM]}
    seen["broadcast"] = sorted(io.broadcast_scan(ARM).items())
    seen["temperatures"] = io.sync_read_register(ARM, "present_temperature")
    for servo in ARM:
        io.write_register(servo, "drive_mode", 4)
        io.write_register(servo, "profile_velocity", 400)
        io.write_register(servo, "torque_enable", 1)
    goals = [2000 + 5 * servo for servo in ARM]
    io.sync_write_register(ARM, "goal_position", goals)
    time.sleep(1.0)
    seen["goals"], seen["positions"] = goals, io.sync_read_register(ARM, "present_position")
    seen["singly"] = [io.read_register(servo, "present_position") for servo in ARM]
    io.set_fast_sync_read(True)
    seen["fast"] = io.sync_read_register(ARM, "present_position")
    io.set_fast_sync_read(False)
    _, seen["locked"] = 0, io.write_register_with_error(12, "drive_mode", 0)
    for i in range(4):
        io.write_register(11, f"indirect_address_{i + 1}", 132 + i)
    seen["indirect"] = int.from_bytes(bytes(io.read_raw_data(11, 224, 4)), "little")
    io.reboot(13)
    time.sleep(0.5)
    seen["after_reboot"] = [io.read_register(13, "torque_enable"), io.read_register(13, "drive_mode")]
    io.factory_reset(13, False, True)
    time.sleep(0.5)
    seen["after_reset"] = io.read_register(13, "drive_mode")
    print(json.dumps(seen))


if __name__ == "__main__":
    main(sys.argv[1])
