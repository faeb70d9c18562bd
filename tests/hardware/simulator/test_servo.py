"""One servo as its registers show it: the rules of the manual, over the wire."""

import math

import pytest

from omx.arm import JOINT_IDS
from omx.errors import BusTimeout, ServoFault, ServoRefused
from omx.hardware.dynamixel import packet as pk
from omx.hardware.dynamixel import registers as reg
from omx.hardware.dynamixel import units
from omx.hardware.robot.servo_group import MOTION_PUSHED
from omx.hardware.simulator.servo import REBOOT_S
from omx.hardware.simulator.wire_timing import Wire
from tests.helpers.rigs import rig, send_to, stiffen


@pytest.fixture
def bus_arm_clock():
    with rig() as parts:
        yield parts


def refused(bus, servo, name, value):
    """The error number with which the servo refuses a write that the bus would let through."""
    row = reg.register(name)
    params = row.address.to_bytes(2, "little") + value.to_bytes(row.size, "little", signed=value < 0)
    with pytest.raises(ServoRefused) as caught:
        bus._ask(servo, pk.Instruction.WRITE, params, [(servo, 0)], "test")
    return caught.value.code


# ---- who may write what ----


def test_a_fresh_servo_holds_the_factory_values(bus_arm_clock):
    bus, _, _ = bus_arm_clock
    own = {"id", "baud_rate", "goal_position", "goal_pwm", "goal_current"}
    for row in reg.REGISTERS.values():
        if row.writable and row.name not in own:
            assert bus.read(12, row.name) == row.default


def test_eeprom_is_locked_while_torque_is_on(bus_arm_clock):
    bus, _, _ = bus_arm_clock
    stiffen(bus, ids=[12])
    assert refused(bus, 12, "drive_mode", 0) == pk.ACCESS
    assert bus.read(12, "drive_mode") == 4
    bus.write(12, "torque_enable", 0)
    bus.write(12, "drive_mode", 0)


@pytest.mark.parametrize(
    ("name", "value", "code"),
    [
        ("model_number", 1, pk.ACCESS),
        ("present_position", 1, pk.ACCESS),
        ("torque_enable", 2, pk.DATA_RANGE),
        ("id", 253, pk.DATA_RANGE),
        ("operating_mode", 2, pk.DATA_RANGE),
        ("drive_mode", 2, pk.DATA_RANGE),
        ("bus_watchdog", 128, pk.DATA_RANGE),
        ("goal_position", 4096, pk.DATA_LIMIT),
        ("goal_position", -1, pk.DATA_LIMIT),
        ("goal_velocity", 201, pk.DATA_LIMIT),
        ("profile_velocity", 40000, pk.DATA_RANGE),
    ],
)
def test_wrong_values_are_refused_with_the_manuals_number(bus_arm_clock, name, value, code):
    bus, _, _ = bus_arm_clock
    before = bus.read(11, name)
    assert refused(bus, 11, name, value) == code
    assert bus.read(11, name) == before


def test_limits_hold_in_position_mode_only(bus_arm_clock):
    bus, _, _ = bus_arm_clock
    bus.write(11, "operating_mode", reg.MODES["extended"])
    bus.write(11, "goal_position", 5000)
    bus.write(11, "operating_mode", reg.MODES["position"])
    bus.write(11, "max_position_limit", 3000)
    assert refused(bus, 11, "goal_position", 3001) == pk.DATA_LIMIT


def test_half_a_register_is_too_short(bus_arm_clock):
    bus, _, _ = bus_arm_clock
    with pytest.raises(ServoRefused) as caught:
        bus._ask(11, pk.Instruction.WRITE, b"\x74\x00\x00\x08", [(11, 0)], "test")
    assert caught.value.code == pk.DATA_LENGTH


def test_undefined_addresses_are_refused(bus_arm_clock):
    bus, _, _ = bus_arm_clock
    for instruction, params in ((pk.Instruction.WRITE, b"\x0e\x00\x01"), (pk.Instruction.READ, b"\x00\x08\x01\x00")):
        with pytest.raises(ServoRefused) as caught:
            bus._ask(11, instruction, params, [(11, 1 if instruction == 2 else 0)], "test")
        assert caught.value.code == pk.ACCESS


# ---- modes ----


def test_a_new_mode_zeroes_the_profile_and_an_old_one_does_not(bus_arm_clock):
    bus, _, _ = bus_arm_clock
    bus.write(12, "profile_velocity", 100)
    bus.write(12, "profile_acceleration", 10)
    bus.write(12, "operating_mode", 3)
    assert bus.read(12, "profile_velocity") == 100
    bus.write(12, "operating_mode", 5)
    assert bus.read(12, "profile_velocity") == bus.read(12, "profile_acceleration") == 0


def test_factory_fresh_the_two_second_move_takes_a_third_of_a_second(bus_arm_clock):
    # Drive mode 0 and torque on: the drive mode cannot be changed, and the profile's 0 means maximum speed.
    bus, _, clock = bus_arm_clock
    start = bus.read(11, "present_position")
    bus.write(11, "torque_enable", 1)
    bus.write(11, "goal_position", start + 910)  # 80 deg
    began = clock.now()
    while bus.read(11, "present_position") < start + 900:
        clock.sleep(0.01)
    assert 0.28 < clock.now() - began < 0.42
    fastest = units.VELOCITY.value(200)
    assert fastest == pytest.approx(math.radians(275), rel=1e-3)


@pytest.mark.parametrize("seconds", [0.5, 2.0, 5.0])
def test_time_based_the_move_takes_the_time_it_was_given(bus_arm_clock, seconds):
    bus, _, clock = bus_arm_clock
    stiffen(bus, seconds)
    start = bus.read(11, "present_position")
    bus.write(11, "goal_position", start + 400)
    began = clock.now()
    while bus.read(11, "moving_status") & 2:
        clock.sleep(0.005)
    assert clock.now() - began == pytest.approx(seconds, abs=0.011)
    clock.sleep(0.3)
    assert abs(bus.read(11, "present_position") - start - 400) <= 3


def test_the_goals_of_other_modes_lay_no_trajectory(bus_arm_clock):
    """One packet with a new current, profile and goal: the joint does not leap to the old goal in between."""
    bus, _, clock = bus_arm_clock
    stiffen(bus, 4.0)
    bus.write(11, "goal_position", 3072)
    clock.sleep(2.0)
    bus.write(11, "profile_velocity", 0)
    here = bus.read(11, "present_position")
    bus.write_block(MOTION_PUSHED, {11: (1193, 0, 0, 200, here)})
    clock.sleep(0.1)
    assert abs(bus.read(11, "present_position") - here) < 40
    assert here < 3000


def test_velocity_based_the_set_point_follows_the_manuals_formula(bus_arm_clock):
    bus, _, clock = bus_arm_clock
    bus.write(11, "profile_velocity", 50)
    bus.write(11, "profile_acceleration", 10)
    bus.write(11, "torque_enable", 1)
    bus.write(11, "goal_position", 2048 + 500)
    clock.sleep(0.2)
    moved, speed = bus.read(11, "position_trajectory") - 2048, bus.read(11, "velocity_trajectory")
    assert moved == pytest.approx(0.5 * 2441.5 * 0.2**2, abs=1.5)  # 10 x 214.577 rpm/min in ticks/s^2
    assert speed == pytest.approx(2441.5 * 0.2 / 15.633, abs=1)
    clock.sleep(0.3)
    assert bus.read(11, "velocity_trajectory") == 50


def test_velocity_mode_turns_on_and_on(bus_arm_clock):
    bus, _, clock = bus_arm_clock
    stiffen(bus, mode="velocity", ids=[11])
    bus.write(11, "profile_acceleration", 0)
    bus.write(11, "goal_velocity", 20)
    clock.sleep(1.0)
    a = bus.read(11, "present_position")
    clock.sleep(1.0)
    b = bus.read(11, "present_position")
    assert b - a == pytest.approx(20 * 15.633, abs=2)
    assert bus.read(11, "present_velocity") == 20
    bus.write(11, "goal_velocity", -20)
    clock.sleep(0.5)
    assert bus.read(11, "present_velocity") == -20


def test_current_mode_pushes_with_the_current_it_is_given(bus_arm_clock):
    bus, arm, clock = bus_arm_clock
    stiffen(bus, mode="current", ids=[15])
    bus.write(15, "goal_current", 100)
    clock.sleep(2.0)  # closes until the fingers meet their stop
    assert bus.read(15, "present_current") == pytest.approx(100, abs=1)
    assert arm.opening == pytest.approx(22.0, abs=0.1)
    bus.write(15, "goal_current", -100)
    clock.sleep(8.0)
    assert arm.opening == pytest.approx(80.0, abs=0.1)


def test_pwm_mode_sets_the_speed_by_the_voltage(bus_arm_clock):
    bus, _, clock = bus_arm_clock
    stiffen(bus, mode="pwm", ids=[11])
    bus.write(11, "goal_pwm", 442)
    clock.sleep(0.2)
    half = units.VELOCITY.value(bus.read(11, "present_velocity"))
    assert half == pytest.approx(46 / 60 * math.tau / 2, rel=0.08)


def test_current_based_position_holds_an_object_without_overload(bus_arm_clock):
    bus, arm, clock = bus_arm_clock
    arm.grip(30.0)
    stiffen(bus, 0.5, mode="current_position", ids=[15])
    bus.write(15, "goal_current", 150)
    bus.write(15, "goal_position", 2560)
    clock.sleep(10.0)
    assert arm.opening == pytest.approx(30.0, abs=0.3)  # 27 N on either side press it a little
    assert bus.read(15, "present_current") == pytest.approx(150, abs=1)
    assert bus.read(15, "hardware_error") == 0


def test_position_mode_on_the_same_object_ends_in_an_overload(bus_arm_clock):
    bus, arm, clock = bus_arm_clock
    arm.grip(30.0)
    stiffen(bus, 0.5, ids=[15])
    bus.write(15, "goal_position", 2560)
    clock.sleep(5.0)
    assert bus.read(15, "hardware_error") == 0x20
    assert bus.read(15, "torque_enable") == 0


def test_torque_on_by_goal(bus_arm_clock):
    bus, _, _ = bus_arm_clock
    bus.write(11, "drive_mode", reg.DRIVE_TORQUE_BY_GOAL)
    bus.write(11, "goal_position", 2100)
    assert bus.read(11, "torque_enable") == 1


def test_torque_on_does_not_forgive_an_old_goal(bus_arm_clock):
    bus, _, clock = bus_arm_clock
    bus.write(11, "goal_position", 3000)
    bus.write(11, "torque_enable", 1)
    clock.sleep(1.0)
    assert bus.read(11, "present_position") == pytest.approx(3000, abs=4)


def test_more_gain_less_sag_and_integral_gain_none(bus_arm_clock):
    bus, _, clock = bus_arm_clock
    stiffen(bus)
    send_to(bus, (0, 0.3, 0.3, 0.3))
    clock.sleep(2.0)

    def sag():
        return bus.read(12, "present_position") - bus.read(12, "goal_position")

    soft = sag()
    bus.write(12, "position_p_gain", 3200)
    clock.sleep(1.0)
    hard = sag()
    bus.write(12, "position_i_gain", 500)
    clock.sleep(3.0)
    assert soft > 2 * hard > 0
    assert abs(sag()) <= 1


# ---- positions ----


def test_reverse_mode_mirrors_position_velocity_and_current_about_the_centre():
    with rig(q=(0.5, 0, 0, 0)) as (bus, arm, clock):
        forward = bus.read(11, "present_position")
        bus.write(11, "drive_mode", 5)
        assert bus.read(11, "present_position") == 4096 - forward
        stiffen(bus)
        bus.write(11, "torque_enable", 0)
        bus.write(11, "drive_mode", 5)
        bus.write(11, "goal_position", 2048)
        bus.write(11, "torque_enable", 1)
        clock.sleep(0.5)
        assert bus.read(11, "present_velocity") > 0
        assert arm.joints[0].speed < 0
        clock.sleep(2.0)
        assert arm.q[0] == pytest.approx(0.0, abs=0.01)


def test_homing_offset_is_added_to_the_position(bus_arm_clock):
    bus, _, _ = bus_arm_clock
    before = bus.read(12, "present_position")
    bus.write(12, "homing_offset", -300)
    assert bus.read(12, "present_position") == before - 300
    bus.write(12, "homing_offset", 5000)  # the manual: ignored in position mode
    assert bus.read(12, "present_position") == before
    bus.write(12, "operating_mode", 4)
    assert bus.read(12, "present_position") == before + 5000


def test_turns_are_counted_in_extended_mode_and_forgotten_by_clear_and_reboot(bus_arm_clock):
    bus, arm, clock = bus_arm_clock
    arm.joints[0].stops(-math.inf, math.inf)
    stiffen(bus, 2.0, mode="extended", ids=[11])
    bus.write(11, "goal_position", 2048 + 2 * 4096)
    clock.sleep(0.5)
    assert instruct(bus, pk.Instruction.CLEAR, pk.CLEAR_TURNS, 11) == pk.RESULT_FAIL  # only at rest
    clock.sleep(4.0)
    far = bus.read(11, "present_position")
    assert far == pytest.approx(2048 + 2 * 4096, abs=4)
    assert instruct(bus, pk.Instruction.CLEAR, pk.CLEAR_TURNS, 11) == 0
    clock.sleep(1.0)
    assert bus.read(11, "present_position") == pytest.approx(far - 2 * 4096, abs=2)


def test_a_position_is_a_whole_number_of_ticks(bus_arm_clock):
    bus, arm, _ = bus_arm_clock
    for servo, angle in zip(JOINT_IDS, arm.q, strict=True):
        assert bus.read(servo, "present_position") == round(2048 + angle * 4096 / math.tau)


# ---- safety devices ----


def test_the_watchdog_stops_the_motor_clears_the_profile_and_locks_the_goals(bus_arm_clock):
    bus, arm, clock = bus_arm_clock
    stiffen(bus, 4.0)
    bus.write(11, "bus_watchdog", 10)  # 200 ms
    bus.write(11, "goal_position", 3000)
    for _ in range(20):
        clock.sleep(0.1)
        bus.read(11, "present_position")  # fed: goes on
    assert arm.joints[0].speed > 0
    clock.sleep(0.3)
    stopped = bus.read(11, "present_position")
    clock.sleep(1.0)
    assert bus.read(11, "present_position") == pytest.approx(stopped, abs=2)
    params = reg.register("bus_watchdog")
    assert params.decode(b"\xff") == bus.read(11, "bus_watchdog") == reg.WATCHDOG_TRIPPED
    assert bus.read(11, "profile_velocity") == bus.read(11, "profile_acceleration") == 0
    assert refused(bus, 11, "goal_position", 2500) == pk.DATA_RANGE
    bus.write(11, "bus_watchdog", 0)
    bus.write(11, "goal_position", 2500)


def test_the_watchdog_sleeps_while_torque_is_off(bus_arm_clock):
    bus, _, clock = bus_arm_clock
    bus.write(11, "bus_watchdog", 5)
    clock.sleep(2.0)
    assert bus.read(11, "bus_watchdog") == 5


def test_an_error_in_the_mask_switches_off_until_a_reboot(bus_arm_clock):
    bus, arm, clock = bus_arm_clock
    stiffen(bus)
    arm.faults.inject("overload", servo=13)
    assert bus.read(13, "torque_enable") == 0
    assert bus.alerts == {13}
    with pytest.raises(ServoFault) as caught:
        bus.write(13, "torque_enable", 1)
    assert caught.value.faults == {13: 0x20}
    bus.reboot(13)
    clock.sleep(0.4)
    assert bus.read(13, "hardware_error") == 0
    bus.write(13, "torque_enable", 1)
    assert not bus.alerts


def test_an_error_outside_the_mask_only_raises_the_alert(bus_arm_clock):
    bus, arm, _ = bus_arm_clock
    stiffen(bus)
    arm.faults.inject("low_voltage", value=9.0)
    arm.advance(arm.now + 0.1)
    assert bus.read(12, "hardware_error") == 0x01
    assert bus.read(12, "torque_enable") == 1
    assert 12 in bus.alerts


def test_a_servo_that_gets_too_hot_switches_off(bus_arm_clock):
    bus, arm, clock = bus_arm_clock
    stiffen(bus)
    arm.faults.inject("hot", servo=12, value=81.4)
    clock.sleep(1.0)
    assert bus.read(12, "hardware_error") == 0x04
    assert bus.read(12, "present_temperature") == 81


def test_reboot_is_silent_for_a_while_and_loses_the_ram(bus_arm_clock):
    bus, _, clock = bus_arm_clock
    stiffen(bus, 2.0)
    bus.reboot(12)
    clock.sleep(REBOOT_S - 0.1)
    with pytest.raises(BusTimeout):
        bus.ping(12)
    clock.sleep(0.1)
    assert bus.read(12, "torque_enable") == 0
    assert bus.read(12, "profile_velocity") == 0
    assert bus.read(12, "drive_mode") == 4  # EEPROM stays


def test_factory_reset_keeps_id_and_baud_rate_if_told_to(bus_arm_clock):
    bus, arm, clock = bus_arm_clock
    bus.write(12, "drive_mode", 4)
    instruct(bus, pk.Instruction.FACTORY_RESET, pk.RESET_BUT_ID_AND_BAUD)
    clock.sleep(0.5)
    assert bus.read(12, "drive_mode") == 0
    instruct(bus, pk.Instruction.FACTORY_RESET, pk.RESET_BUT_ID)
    clock.sleep(0.5)
    with pytest.raises(BusTimeout):
        bus.ping(12)
    assert arm.servo(12).baud == 57600


def test_indirect_data_reads_and_writes_what_its_address_points_at(bus_arm_clock):
    bus, _, _ = bus_arm_clock
    for i, address in enumerate(range(132, 136), start=1):
        bus.write(12, f"indirect_address_{i}", address)
    block = reg.block(*(f"indirect_data_{i}" for i in range(1, 5)))
    through = bytes(bus.read_block([12], block)[12])
    assert int.from_bytes(through, "little") == bus.read(12, "present_position")
    for i, address in enumerate(range(116, 120), start=29):
        bus.write(12, f"indirect_address_{i}", address)
    params = (634).to_bytes(2, "little") + (1999).to_bytes(4, "little")
    bus._ask(12, pk.Instruction.WRITE, params, [(12, 0)], "test")
    assert bus.read(12, "goal_position") == 1999


def test_old_firmware_has_no_watchdog_no_time_based_profile_and_no_fast_reads():
    with rig(settings={11: {"firmware_version": 36}}) as (bus, _, clock):
        assert refused(bus, 11, "bus_watchdog", 10) == pk.ACCESS
        stiffen(bus, 2.0, ids=[11])
        bus.write(11, "goal_position", 2300)
        clock.sleep(1.0)
        assert abs(bus.read(11, "present_position") - 2300) < 5  # 2000 was taken for a speed
        with pytest.raises(BusTimeout):
            bus._ask(pk.BROADCAST, pk.Instruction.FAST_SYNC_READ, b"\x84\x00\x04\x00\x0b", [(11, 4)], "test")


# ---- backup, start, Protocol 1.0 ----


def instruct(bus, instruction, params, servo=12):
    """What a servo answers to an instruction that `Bus` has no method for: error number 0, or the refusal's."""
    try:
        bus._ask(servo, instruction, params, [(servo, 0)], "test")
    except ServoRefused as refusal:
        return refusal.code
    return 0


def test_a_backup_keeps_eeprom_and_gains_and_comes_back_with_a_reboot(bus_arm_clock):
    bus, _, clock = bus_arm_clock
    assert instruct(bus, pk.Instruction.BACKUP, pk.RESTORE) == pk.RESULT_FAIL  # nothing is kept yet
    assert instruct(bus, pk.Instruction.BACKUP, b"\x01") == pk.DATA_RANGE
    bus.write(12, "homing_offset", -400)
    bus.write(12, "position_p_gain", 400)
    bus.write(12, "torque_enable", 1)
    assert instruct(bus, pk.Instruction.BACKUP, pk.STORE) == pk.RESULT_FAIL
    bus.write(12, "torque_enable", 0)
    assert instruct(bus, pk.Instruction.BACKUP, pk.STORE) == 0
    assert bus.read(12, "backup_ready") == 1
    bus.write(12, "homing_offset", 0)
    assert instruct(bus, pk.Instruction.BACKUP, pk.RESTORE) == 0
    clock.sleep(REBOOT_S + 0.01)
    assert bus.read(12, "homing_offset") == -400
    assert bus.read(12, "position_p_gain") == reg.REGISTERS["position_p_gain"].default
    bus.write(12, "startup_configuration", reg.STARTUP_RESTORE_RAM)
    bus.reboot(12)
    clock.sleep(REBOOT_S + 0.01)
    assert bus.read(12, "position_p_gain") == 400


def test_a_servo_may_start_with_its_torque_on_where_it_stands(bus_arm_clock):
    bus, arm, clock = bus_arm_clock
    bus.write(13, "startup_configuration", reg.STARTUP_TORQUE_ON)
    before = arm.q[2]
    bus.reboot(13)
    clock.sleep(REBOOT_S + 0.01)
    assert bus.read(13, "torque_enable") == 1
    clock.sleep(2.0)
    assert arm.q[2] == pytest.approx(before, abs=0.02)
    with rig(settings={12: {"startup_configuration": 1}, 13: {"firmware_version": 44}}) as (bus, _, _):
        assert bus.read_all([12, 13], "torque_enable") == {12: 1, 13: 0}
        assert refused(bus, 13, "startup_configuration", 1) == pk.ACCESS


def test_in_protocol_1_a_servo_is_deaf_to_2_and_can_be_set_back(bus_arm_clock):
    bus, arm, _ = bus_arm_clock
    bus.write(12, "protocol_type", 1)
    with pytest.raises(BusTimeout):
        bus.ping(12)
    assert bus.ping(11)
    wire = Wire(arm)

    def ask(*body):
        wire.send(b"\xff\xff" + bytes((*body, ~sum(body) & 0xFF)), arm.now)
        return wire.receive(100, arm.now)

    assert ask(12, 2, 1) == b"\xff\xff\x0c\x02\x00\xf1"
    assert ask(12, 4, 2, 0, 2)[5:7] == (1020).to_bytes(2, "little")
    assert ask(12, 2, 0x55)[4] == 0x40
    assert ask(0xFE, 6, 0x83, 65, 1, 12, 1) == b""  # to all: LED on
    assert arm.servo(12).table["led"] == 1
    ask(12, 4, 3, 13, 2)
    assert bus.ping(12)


def test_the_integral_gain_comes_to_rest(bus_arm_clock):
    bus, arm, clock = bus_arm_clock
    stiffen(bus)
    for servo in JOINT_IDS:
        bus.write(servo, "position_i_gain", 100)  # what the maker's ros2_control sets
    send_to(bus, (0.3, 0.2, 0.1, 0.0))
    clock.sleep(60.0)
    arm.catch_up()
    assert not arm.busy
    bus.write(12, "goal_position", bus.read(12, "goal_position") + 100)
    clock.sleep(60.0)
    arm.catch_up()
    assert not arm.busy
    assert abs(bus.read(12, "present_position") - bus.read(12, "goal_position")) <= 1


# ---- what an ideal arm has not ----


def test_an_encoder_that_is_not_straight_puts_the_joint_beside_its_goal():
    with rig(encoder_ripple_deg=0.5) as (bus, arm, clock):
        stiffen(bus)
        worst = 0.0
        for q1 in (-2.0, -1.0, 0.0, 1.0, 2.0):
            goal = send_to(bus, (q1, -0.9, 0.3, 0.7))
            clock.sleep(3.0)
            assert bus.read(11, "present_position") == pytest.approx(goal[11], abs=3)  # it believes that it is there
            worst = max(worst, abs(arm.q[0] - q1))
        assert math.radians(0.3) < worst < math.radians(0.8)


def test_a_noisy_encoder_reads_the_same_whoever_asks_and_spreads_as_the_data_sheet_says():
    with rig(encoder_noise_deg=0.06) as (bus, arm, clock):
        seen = []
        for _ in range(300):
            clock.sleep(0.01)
            first = bus.read(11, "present_position")
            assert bus.read(11, "present_position") == first
            seen.append(first)
        spread = math.radians(360 / 4096) * (sum((s - 2048) ** 2 for s in seen) / len(seen)) ** 0.5
        assert spread == pytest.approx(math.radians(0.065), rel=0.15)  # rounding to ticks adds a little
        assert arm.q[0] == 0.0


def test_play_lets_the_links_lean_the_way_they_are_pushed():
    with rig(backlash_deg=0.25) as (bus, arm, clock):
        stiffen(bus)
        send_to(bus, (0.5, 0.0, 0.0, 0.0))
        clock.sleep(3.0)
        half = math.radians(0.125)
        leans = [q - joint.angle for q, joint in zip(arm.q, arm.joints[:4], strict=True)]
        assert leans == pytest.approx([-half, half, half, half])  # joint 1 lags, the others hang


def test_a_payload_asks_for_more_current():
    with rig(q=(0.0, 0.0, 0.0, 0.0)) as (bus, _, clock), rig(q=(0.0, 0.0, 0.0, 0.0), payload_g=500) as (other, _, slow):
        for one, time in ((bus, clock), (other, slow)):
            stiffen(one)
            time.sleep(1.0)
        more = units.CURRENT.value(bus.read(12, "present_current") - other.read(12, "present_current"))
        assert more == pytest.approx(0.5 * 9.81 * 0.274 / 4.1 * 2300, abs=20)


# ---- between the fingers ----


def squeeze(bus, current):
    stiffen(bus, 0.5, mode="current_position", ids=[15])
    bus.write(15, "goal_current", current)
    bus.write(15, "goal_position", 2560)


def test_an_object_is_carried_for_minutes_and_its_weight_is_felt(bus_arm_clock):
    bus, arm, clock = bus_arm_clock
    stiffen(bus, ids=JOINT_IDS)
    clock.sleep(1.0)
    empty = bus.read(14, "present_current")
    arm.grip(30.0, mass_g=200)
    squeeze(bus, 70)
    clock.sleep(600.0)
    assert arm.grasped.carried
    assert bus.read(14, "present_current") < empty - 10
    assert bus.read(15, "present_temperature") < 35
    assert bus.read(15, "hardware_error") == 0


def test_an_object_held_too_weakly_is_lost_and_the_fingers_close(bus_arm_clock):
    bus, arm, clock = bus_arm_clock
    arm.grip(30.0, mass_g=400)
    squeeze(bus, 70)
    clock.sleep(4.0)
    assert arm.grasped.carried
    bus.write(15, "goal_current", 40)
    clock.sleep(2.0)
    assert arm.grasped.carried  # the gearbox's friction still holds the fingers where they are
    bus.write(15, "goal_position", 1536)
    clock.sleep(2.0)
    assert arm.grasped is None
    squeeze(bus, 200)
    clock.sleep(2.0)
    assert arm.opening == pytest.approx(24.0, abs=0.5)  # nothing is between them


def test_a_soft_object_is_pressed_flatter_than_a_hard_one(bus_arm_clock):
    bus, arm, clock = bus_arm_clock
    openings = []
    for stiffness in (2.0, 200.0):
        arm.grip(50.0, stiffness=stiffness)
        squeeze(bus, 100)
        clock.sleep(3.0)
        openings.append(arm.opening)
        bus.write(15, "goal_position", 1536)
        clock.sleep(3.0)
    assert openings[0] < 50 - 5 < openings[1] < 50
