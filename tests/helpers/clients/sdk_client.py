"""Drives an arm with the maker's `dynamixel_sdk`: argument 1 is the port. Prints what it saw, as JSON. No omx here."""

import json
import sys
import time

import dynamixel_sdk as sdk
import serial

ARM = [11, 12, 13, 14, 15]
TORQUE, DRIVE_MODE, PROFILE, GOAL, PRESENT, TEMPERATURE = 64, 10, 112, 116, 132, 146


class PatientPort(sdk.PortHandler):
    """The SDK's port; it waits longer, for another process is between, on a machine that may be busy."""

    def setPacketTimeout(self, packet_length):
        super().setPacketTimeout(packet_length)
        self.packet_timeout += 500


class SocketPort(PatientPort):
    """The same on a socket:// URL, which the SDK does not open by itself."""

    def setupPort(self, cflag_baud):
        if self.is_open:
            self.closePort()
        self.ser = serial.serial_for_url(self.port_name, timeout=0.002)
        self.is_open = True
        self.tx_time_per_byte = 10_000 / self.baudrate
        return True


def good(result):
    """The value of an SDK tuple whose status and error must be in order."""
    *values, status, error = result
    assert (status, error) == (sdk.COMM_SUCCESS, 0), (status, error)
    return values[0] if values else None


def sent(status):
    """A status that must be success."""
    assert status == sdk.COMM_SUCCESS, status


def group_reads(port, handler):
    """Present positions by sync read and by fast sync read."""
    reader = sdk.GroupSyncRead(port, handler, PRESENT, 4)
    for servo in ARM:
        assert reader.addParam(servo)
    sent(reader.txRxPacket())
    plain = [reader.getData(servo, PRESENT, 4) for servo in ARM]
    sent(reader.fastSyncRead())
    return plain, [reader.getData(servo, PRESENT, 4) for servo in ARM]


def bulk(port, handler):
    """A bulk write, read back by bulk read and by fast bulk read."""
    writer = sdk.GroupBulkWrite(port, handler)
    assert writer.addParam(11, GOAL, 4, (2100).to_bytes(4, "little"))
    assert writer.addParam(12, 65, 1, [1])
    sent(writer.txPacket())
    reader = sdk.GroupBulkRead(port, handler)
    assert reader.addParam(11, GOAL, 4)
    assert reader.addParam(12, TEMPERATURE, 1)
    sent(reader.txRxPacket())
    plain = [reader.getData(11, GOAL, 4), reader.getData(12, TEMPERATURE, 1)]
    sent(reader.fastBulkRead())
    return plain, [reader.getData(11, GOAL, 4), reader.getData(12, TEMPERATURE, 1)]


def main(name):
    """Ping, read, write, sync, fast sync, bulk, fast bulk, registered write, indirect, clear, reboot, factory reset."""
    port, handler = (SocketPort if "://" in name else PatientPort)(name), sdk.PacketHandler(2.0)
    assert port.openPort()
    assert port.setBaudRate(1_000_000)
    found, status = handler.broadcastPing(port)
    sent(status)
    seen = {"models": [good(handler.ping(port, servo)) for servo in ARM], "broadcast": sorted(found)}
    writer = sdk.GroupSyncWrite(port, handler, GOAL, 4)
    seen["goals"] = [2000 + 5 * servo for servo in ARM]
    for servo, goal in zip(ARM, seen["goals"], strict=True):
        good(handler.write1ByteTxRx(port, servo, DRIVE_MODE, 4))
        good(handler.write4ByteTxRx(port, servo, PROFILE, 400))
        good(handler.write1ByteTxRx(port, servo, TORQUE, 1))
        assert writer.addParam(servo, goal.to_bytes(4, "little"))
    sent(writer.txPacket())
    time.sleep(1.0)
    seen["positions"], seen["fast"] = group_reads(port, handler)
    seen["singly"] = [good(handler.read4ByteTxRx(port, servo, PRESENT)) for servo in ARM]
    _, seen["locked"] = handler.write1ByteTxRx(port, 12, DRIVE_MODE, 0)
    seen["bulk"], seen["fast_bulk"] = bulk(port, handler)
    good(handler.regWriteTxRx(port, 11, GOAL, 4, list((2050).to_bytes(4, "little"))))
    seen["before_action"] = good(handler.read4ByteTxRx(port, 11, GOAL))
    sent(handler.action(port, sdk.BROADCAST_ID))  # for one servo the SDK would leave its answer unread
    seen["after_action"] = good(handler.read4ByteTxRx(port, 11, GOAL))
    for i in range(4):
        good(handler.write2ByteTxRx(port, 11, 168 + 2 * i, GOAL + i))
    seen["indirect"] = good(handler.read4ByteTxRx(port, 11, 224))
    good(handler.clearMultiTurn(port, 12))
    good(handler.reboot(port, 13))
    time.sleep(0.5)
    seen["after_reboot"] = [good(handler.read1ByteTxRx(port, 13, a)) for a in (TORQUE, DRIVE_MODE)]
    good(handler.factoryReset(port, 13, 0x02))
    time.sleep(0.5)
    seen["after_reset"] = good(handler.read1ByteTxRx(port, 13, DRIVE_MODE))
    port.closePort()
    print(json.dumps(seen))


if __name__ == "__main__":
    main(sys.argv[1])
