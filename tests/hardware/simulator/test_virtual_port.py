"""The in-process port, driven by the maker's SDK as its own examples use it."""

import time

import dynamixel_sdk as sdk
import pytest

from omx.arm import ARM_IDS
from omx.errors import PortBusy, PortLost
from omx.hardware.simulator import Clock, SteppedClock, VirtualArm, VirtualPort

PRESENT_POSITION, GOAL_POSITION, TORQUE = 132, 116, 64


@pytest.fixture
def port():
    port = VirtualPort(VirtualArm(), SteppedClock())
    assert port.openPort()
    yield port
    port.closePort()


@pytest.fixture
def handler():
    return sdk.PacketHandler(2.0)


def ok(result):
    *values, status, error = result
    assert status == sdk.COMM_SUCCESS
    assert error == 0
    return values[0] if values else None


def test_read_and_write(port, handler):
    assert ok(handler.ping(port, 11)) == 1020
    ok(handler.write1ByteTxRx(port, 11, TORQUE, 1))
    ok(handler.write4ByteTxRx(port, 11, GOAL_POSITION, 2300))
    port.clock.sleep(2.0)
    assert ok(handler.read4ByteTxRx(port, 11, PRESENT_POSITION)) == pytest.approx(2300, abs=4)
    assert ok(handler.read1ByteTxRx(port, 11, 146)) == 25


def test_broadcast_ping_finds_all(port, handler):
    found, status = handler.broadcastPing(port)
    assert status == sdk.COMM_SUCCESS
    assert found == {servo: [1020, 45] for servo in ARM_IDS}


@pytest.mark.parametrize("fast", [False, True])
def test_group_sync_read_and_write(port, handler, fast):
    reader = sdk.GroupSyncRead(port, handler, PRESENT_POSITION, 4)
    writer = sdk.GroupSyncWrite(port, handler, GOAL_POSITION, 4)
    for servo in ARM_IDS:
        ok(handler.write1ByteTxRx(port, servo, TORQUE, 1))
        assert reader.addParam(servo)
        assert writer.addParam(servo, (2000 + servo).to_bytes(4, "little"))
    assert writer.txPacket() == sdk.COMM_SUCCESS
    port.clock.sleep(2.0)
    assert (reader.fastSyncRead() if fast else reader.txRxPacket()) == sdk.COMM_SUCCESS
    for servo in ARM_IDS:
        assert reader.isAvailable(servo, PRESENT_POSITION, 4)
        assert reader.getData(servo, PRESENT_POSITION, 4) == pytest.approx(2000 + servo, abs=12)


@pytest.mark.parametrize("fast", [False, True])
def test_group_bulk_read_and_write(port, handler, fast):
    writer = sdk.GroupBulkWrite(port, handler)
    assert writer.addParam(11, GOAL_POSITION, 4, (2222).to_bytes(4, "little"))
    assert writer.addParam(12, 65, 1, [1])
    assert writer.txPacket() == sdk.COMM_SUCCESS
    reader = sdk.GroupBulkRead(port, handler)
    assert reader.addParam(11, GOAL_POSITION, 4)
    assert reader.addParam(12, 65, 1)
    assert (reader.fastBulkRead() if fast else reader.txRxPacket()) == sdk.COMM_SUCCESS
    assert reader.getData(11, GOAL_POSITION, 4) == 2222
    assert reader.getData(12, 65, 1) == 1


def test_registered_writes(port, handler):
    for servo in (11, 12):
        ok(handler.regWriteTxRx(port, servo, GOAL_POSITION, 4, list((2100).to_bytes(4, "little"))))
    assert ok(handler.read4ByteTxRx(port, 11, GOAL_POSITION)) != 2100
    assert handler.action(port, sdk.BROADCAST_ID) == sdk.COMM_SUCCESS
    assert ok(handler.read4ByteTxRx(port, 11, GOAL_POSITION)) == 2100


def test_reboot_clear_and_factory_reset(port, handler):
    ok(handler.clearMultiTurn(port, 11))
    ok(handler.reboot(port, 11))
    _, status, _ = handler.ping(port, 11)
    assert status == sdk.COMM_RX_TIMEOUT
    port.clock.sleep(0.4)
    ok(handler.write1ByteTxRx(port, 11, 10, 4))
    ok(handler.factoryReset(port, 11, 0x02))
    port.clock.sleep(0.4)
    assert ok(handler.read1ByteTxRx(port, 11, 10)) == 0


def test_indirect_addresses(port, handler):
    for i in range(4):
        ok(handler.write2ByteTxRx(port, 11, 168 + 2 * i, PRESENT_POSITION + i))
    assert ok(handler.read4ByteTxRx(port, 11, 224)) == ok(handler.read4ByteTxRx(port, 11, PRESENT_POSITION))


def test_a_wrong_baud_rate_meets_silence(port, handler):
    port.setBaudRate(57600)
    _, status, _ = handler.ping(port, 11)
    assert status == sdk.COMM_RX_TIMEOUT
    port.setBaudRate(1_000_000)
    ok(handler.ping(port, 11))


def test_one_opener_at_a_time():
    arm = VirtualArm()
    first, second = VirtualPort(arm), VirtualPort(arm)
    first.openPort()
    with pytest.raises(PortBusy, match="Close"):
        second.openPort()
    first.closePort()
    second.openPort()
    second.closePort()


def test_a_pulled_plug_is_a_lost_port(port, handler):
    port.arm.faults.inject("unplugged")
    with pytest.raises(PortLost, match="plug"):
        handler.ping(port, 11)
    assert not port.is_open


def test_silence_costs_its_time_on_the_clock_and_no_computing():
    port = VirtualPort(VirtualArm(), Clock(10))
    port.openPort()
    handler = sdk.PacketHandler(2.0)
    began, cpu = port.clock.now(), time.process_time()
    for _ in range(10):
        handler.ping(port, 99)
    passed, used = port.clock.now() - began, time.process_time() - cpu
    assert passed > 0.34
    assert used < 0.5 * passed / 10 + 0.02
    port.closePort()


def test_scaled_time_moves_the_arm_faster():
    port = VirtualPort(VirtualArm(), Clock(50))
    port.openPort()
    handler = sdk.PacketHandler(2.0)
    ok(handler.write1ByteTxRx(port, 11, TORQUE, 1))
    ok(handler.write4ByteTxRx(port, 11, GOAL_POSITION, 3000))
    time.sleep(0.06)
    assert ok(handler.read4ByteTxRx(port, 11, PRESENT_POSITION)) == pytest.approx(3000, abs=4)
    port.closePort()
