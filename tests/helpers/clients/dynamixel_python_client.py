"""Drives an arm with `dynamixel-python`: argument 1 is the port. Prints what it saw, as JSON. No omx in here."""

import json
import sys
import time

import serial
from dxl2 import v2

ARM = [11, 12, 13, 14, 15]
TORQUE, DRIVE_MODE, PROFILE, GOAL, PRESENT, TEMPERATURE = 64, 10, 112, 116, 132, 146


def good(response):
    """The data of a response that must be in order."""
    assert response.ok, response
    return response.data


def main(port):
    """Every method of its bus that a Protocol 2.0 servo of this kind knows."""
    bus = v2.MotorBus(port, timeout=1.0)
    if "://" in port:
        bus.conn.serial = serial.serial_for_url(port, timeout=1.0)
    else:
        bus.connect()
    seen = {"pings": [good(bus.ping(servo)) for servo in ARM], "broadcast": sorted(good(bus.broadcast_ping()))}
    for servo in ARM:
        good(bus.write(servo, DRIVE_MODE, 1, 4))
        good(bus.write(servo, PROFILE, 4, 400))
        good(bus.write(servo, TORQUE, 1, 1))
    seen["goals"] = [2000 + 5 * servo for servo in ARM]
    wanted = v2.SyncParams(GOAL, 4)
    for servo, goal in zip(ARM, seen["goals"], strict=True):
        wanted.add_value(servo, goal)
    bus.sync_write(wanted)
    time.sleep(1.0)
    asked = v2.SyncParams(PRESENT, 4)
    for servo in ARM:
        asked.add_motor(servo)
    seen["positions"] = good(bus.sync_read(asked))
    seen["fast"] = good(bus.fast_sync_read(asked))
    seen["singly"] = [good(bus.read(servo, PRESENT, 4)) for servo in ARM]
    seen["locked"] = bus.write(12, DRIVE_MODE, 1, 0).error

    mixed = v2.BulkParams()
    mixed.add_value(11, GOAL, 4, 2100)
    mixed.add_value(12, 65, 1, 1)
    bus.bulk_write(mixed)
    both = v2.BulkParams()
    both.add_address(11, GOAL, 4)
    both.add_address(12, TEMPERATURE, 1)
    seen["bulk"], seen["fast_bulk"] = good(bus.bulk_read(both)), good(bus.fast_bulk_read(both))

    good(bus.reg_write(11, GOAL, 4, 2050))
    seen["before_action"] = good(bus.read(11, GOAL, 4))
    good(bus.action(11))
    seen["after_action"] = good(bus.read(11, GOAL, 4))
    for i in range(4):
        good(bus.write(11, 168 + 2 * i, 2, GOAL + i))
    seen["indirect"] = good(bus.read(11, 224, 4))
    good(bus.clear_position(12))
    good(bus.reboot(13))
    time.sleep(0.5)
    seen["after_reboot"] = [good(bus.read(13, TORQUE, 1)), good(bus.read(13, DRIVE_MODE, 1))]
    good(bus.factory_reset_except_id_baudrate(13))
    time.sleep(0.5)
    seen["after_reset"] = good(bus.read(13, DRIVE_MODE, 1))
    bus.disconnect()
    print(json.dumps(seen))


if __name__ == "__main__":
    main(sys.argv[1])
