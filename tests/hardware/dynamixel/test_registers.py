"""The control table: consistent with itself, and strict with its callers."""

import copy

import pytest
from hypothesis import given, settings
from hypothesis import strategies as st

from omx.errors import BadInput
from omx.hardware.dynamixel import registers as reg

ROWS = list(reg.REGISTERS.values())

# Address, size and initial value of rows that everything else leans on, typed in again from the e-manual.
MANUAL = {
    "model_number": (0, 2, 1020), "id": (7, 1, 1), "baud_rate": (8, 1, 1), "return_delay_time": (9, 1, 250),
    "drive_mode": (10, 1, 0), "operating_mode": (11, 1, 3), "homing_offset": (20, 4, 0),
    "temperature_limit": (31, 1, 80), "max_voltage_limit": (32, 2, 160), "min_voltage_limit": (34, 2, 95),
    "pwm_limit": (36, 2, 885), "current_limit": (38, 2, 1193), "velocity_limit": (44, 4, 200),
    "max_position_limit": (48, 4, 4095), "min_position_limit": (52, 4, 0), "shutdown": (63, 1, 52),
    "torque_enable": (64, 1, 0), "status_return_level": (68, 1, 2), "hardware_error": (70, 1, 0),
    "position_d_gain": (80, 2, 0), "position_i_gain": (82, 2, 0), "position_p_gain": (84, 2, 800),
    "bus_watchdog": (98, 1, 0), "profile_acceleration": (108, 4, 0), "profile_velocity": (112, 4, 0),
    "present_current": (126, 2, 0), "present_velocity": (128, 4, 0), "velocity_trajectory": (136, 4, 0),
    "indirect_address_1": (168, 2, 224), "indirect_data_1": (224, 1, 0), "indirect_address_28": (222, 2, 251),
    "indirect_address_29": (578, 2, 634), "indirect_data_56": (661, 1, 0),
}  # fmt: skip


@pytest.mark.parametrize("name", MANUAL)
def test_rows_agree_with_the_manual(name):
    row = reg.REGISTERS[name]
    assert (row.address, row.size, row.default) == MANUAL[name]


def test_no_two_registers_share_a_byte():
    taken = [address for row in ROWS for address in range(row.address, row.end)]
    assert len(taken) == len(set(taken))


def test_every_default_is_legal_and_fits():
    for row in ROWS:
        assert row.low <= row.default <= row.high
        assert row.decode(row.encode(row.default)) == row.default


def test_no_register_straddles_the_eeprom_boundary():
    assert all(row.end <= reg.RAM for row in ROWS if row.eeprom)


@settings(deadline=None)
@given(st.sampled_from(ROWS), st.data())
def test_encode_then_decode_is_identity(row, data):
    value = data.draw(st.integers(row.low, row.high))
    raw = row.encode(value)
    assert len(raw) == row.size
    assert row.decode(raw) == value


@pytest.mark.parametrize(("value", "word"), [(3.5, "whole"), ("5", "whole"), (None, "whole"), (2_000_000, "nearest")])
def test_a_wrong_value_is_refused_with_a_reason(value, word):
    with pytest.raises(BadInput, match=word):
        reg.register("goal_position").encode(value)


def test_a_wrong_name_is_refused_with_the_closest_names():
    with pytest.raises(BadInput, match="present_position"):
        reg.register("presentposition")


def test_what_one_look_at_a_servo_reads():
    assert (reg.PRESENT.address, reg.PRESENT.size) == (126, 10)
    raw = (
        (-3).to_bytes(2, "little", signed=True) + (-7).to_bytes(4, "little", signed=True) + (2048).to_bytes(4, "little")
    )
    assert reg.PRESENT.decode(raw) == (-3, -7, 2048)


def test_a_block_has_no_gap():
    with pytest.raises(BadInput, match="gap"):
        reg.block("present_current", "present_position")
    with pytest.raises(BadInput, match="none"):
        reg.block()


def test_a_block_that_has_been_read_can_be_copied():
    block = reg.block("present_current", "present_velocity", "present_position")
    decoded = block.decode(bytes(range(block.size)))
    assert copy.deepcopy(block).decode(bytes(range(block.size))) == decoded


def test_registers_within_a_range_are_whole():
    assert [row.name for row in reg.within(126, 10)] == [
        "present_current",
        "present_velocity",
        "present_position",
    ]
    assert [row.name for row in reg.within(127, 8)] == ["present_velocity"]
    assert reg.at(14) is None


def test_hardware_errors_in_words():
    assert reg.hardware_errors(0) == []
    assert reg.hardware_errors(0x24) == ["overheated", "overload"]
