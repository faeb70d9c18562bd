"""The doctor: each illness brought about on a virtual arm is found and named, and nothing is ever written."""

import errno
import importlib.metadata
import math
import os
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
import serial

import omx
from omx import errors
from omx.arm import ARM_IDS, JOINT_IDS
from omx.hardware.doctor import doctor
from omx.hardware.doctor.__main__ import main
from omx.hardware.doctor.diagnoses import ILLNESSES
from omx.hardware.doctor.report import Report, find
from omx.hardware.doctor.software_checks import examine_software, holder
from omx.hardware.dynamixel import registers as reg
from omx.hardware.dynamixel.bus import Bus
from omx.hardware.fault_table import CONDITIONS
from omx.hardware.robot import Robot
from omx.hardware.simulator import SteppedClock, VirtualArm, VirtualPort

READING = {0x01, 0x02, 0x82}  # ping, read, sync read


def examined(*faults, pose=None, arm=None, **wire):
    """The report on an arm with these faults, (kind, options) each; it must not have been written to."""
    arm = arm or VirtualArm()
    for kind, options in faults:
        arm.faults.inject(kind, **options)
    with Bus(VirtualPort(arm, clock=SteppedClock(), **wire), history=10_000) as bus:
        before, stood = tables(arm), arm.q
        report = doctor(bus, pose)
        assert tables(arm) == before
        assert arm.q == pytest.approx(stood, abs=1e-3) or any(s.been_on for s in arm.servos)
        assert {sent.sent[7] for sent in bus.history} <= READING
    return report


def tables(arm):
    return [{row.name: servo.table[row.name] for row in reg.REGISTERS.values() if row.writable} for servo in arm.servos]


def wrong(report):
    return {finding.key for finding in report.findings if finding.level != "note"}


def the(report, key):
    """The only finding called `key`."""
    (found,) = [finding for finding in report.findings if finding.key == key]
    return found


# ---- a healthy arm, and no arm ----


def test_a_healthy_arm_has_nothing_to_mend():
    report = examined()
    assert report.healthy
    assert "Nothing to mend." in str(report)
    assert str(report).count("would move at full speed") == 1, "said once for all servos"
    assert report.keys == {"no_profile", "slow_return"}  # as they come from the factory; both are notes


def test_an_arm_that_a_robot_has_set_up_is_healthy_and_goes_on_moving():
    robot = Robot(clock=SteppedClock())
    robot.write_motor_state(True)
    robot.write_time(5)
    robot.write_joints([30, -60, 20, 40])
    assert doctor(robot).keys == {"slow_return", "torque_on"}
    robot.driver.wait()
    assert robot.get_joints_readings()[0][0] == pytest.approx(30, abs=1)
    robot.bus.close()


def test_without_a_port_the_software_is_examined_and_the_virtual_arm_offered(monkeypatch):
    monkeypatch.setattr("omx.hardware.doctor.examination.find_ports", list)
    report = doctor()
    assert wrong(report) == {"no_ports"}
    assert str(report).endswith("1 thing to mend if an arm is plugged in, nothing if you have none.")
    assert any("dynamixel-sdk" in fact for fact in report.facts)
    for system in ("linux", "darwin", "win32"):
        assert "--virtual" in find("no_ports", system=system).remedy


def test_every_illness_reads_as_a_sentence_on_every_system():
    facts = {"port": "COM5", "ids": "11", "ms": 16.0, "short": "ttyUSB0", "who": "", "why": "x", "reason": "y"}
    facts |= dict.fromkeys(("found", "wanted", "off", "back", "low", "high", "value", "degrees"), 1.0)
    facts |= dict.fromkeys((*reg.REGISTERS, "count", "asked", "before", "joint", "us", "baud"), 1)
    facts |= dict.fromkeys(("missing", "words", "text", "angles", "version", "package", "rival", "what"), "z")
    for key in ILLNESSES:
        for system in ("linux", "darwin", "win32"):
            found = find(key, 12, system, **{**facts, "wanted": "w" if key == "sdk_shadowed" else 1.0})
            told = str(Report([found]))
            assert "{" not in told.replace("ATTR{latency_timer}", "")
            assert f"why: {found.cause}" in told


# ---- the port ----


@pytest.mark.parametrize(
    ("number", "key"), [(errno.EACCES, "no_permission"), (errno.ENOENT, "port_absent"), (errno.EBUSY, "port_busy")]
)
def test_a_port_that_the_system_refuses(monkeypatch, number, key):
    def refuse(*args, **kwargs):
        raise serial.SerialException(number, os.strerror(number))

    monkeypatch.setattr(serial, "Serial", refuse)
    report = doctor("/dev/ttyUSB0")
    assert wrong(report) == {key}
    assert "ttyUSB0" in the(report, key).symptom


def test_permission_is_told_for_each_system():
    assert "dialout" in find("no_permission", system="linux", port="p").remedy
    assert "777" in find("no_permission", system="linux", port="p").remedy
    assert "dialout" not in find("no_permission", system="win32", port="p").remedy


def test_a_port_that_someone_else_has():
    arm = VirtualArm()
    with Bus(VirtualPort(arm)):
        assert wrong(doctor(VirtualPort(arm))) == {"port_busy"}


@pytest.mark.skipif(sys.platform != "linux", reason="only Linux tells who has a file open")
def test_the_holder_of_a_port_is_named(tmp_path):
    target = tmp_path / "port"
    target.touch()
    code = "import sys; f = open(sys.argv[1]); print('open', flush=True); sys.stdin.read()"
    command = [sys.executable, "-c", code, str(target)]
    with subprocess.Popen(command, stdin=subprocess.PIPE, stdout=subprocess.PIPE, text=True) as other:
        other.stdout.readline()
        assert str(other.pid) in holder(str(target))
        other.stdin.close()
    assert holder(str(target)) == ""


def test_the_plug_is_pulled_while_the_doctor_looks():
    arm = VirtualArm()
    with Bus(VirtualPort(arm, clock=SteppedClock())) as bus:
        arm.faults.inject("unplugged")
        assert wrong(doctor(bus)) == {"port_lost"}


# ---- who answers ----


def test_no_power_is_silence():
    report = examined(("no_power", {}))
    assert wrong(report) == {"silent"}
    for word in ("12 V", "TTL", "usb_to_dxl"):
        assert word in the(report, "silent").remedy


@pytest.mark.parametrize("code", [1, 2, 4, 5, 6])
def test_an_arm_at_another_baud_rate_is_found(code):
    report = examined(*(("wrong_baud", {"servo": servo, "value": code}) for servo in ARM_IDS))
    assert wrong(report) == {"other_baud"}
    assert str(reg.BAUDS[code]) in the(report, "other_baud").symptom


def test_one_servo_at_another_baud_rate_is_found_and_not_called_missing():
    report = examined(("wrong_baud", {"servo": 13, "value": 1}))
    assert wrong(report) == {"other_baud"}
    assert the(report, "other_baud").servo == 13


@pytest.mark.parametrize("first", [12, 13, 14, 15])
def test_the_first_missing_servo_is_where_the_chain_is_broken(first):
    report = examined(("broken_chain", {"servo": first}))
    assert wrong(report) == {"chain_broken"}
    assert f"between servo {first - 1} and servo {first}" in the(report, "chain_broken").remedy


@pytest.mark.parametrize("servo", [11, 12, 13, 14])
def test_a_single_missing_servo(servo):
    report = examined(("dead", {"servo": servo}))
    assert wrong(report) == {"servo_missing"}
    assert the(report, "servo_missing").servo == servo


def test_a_servo_fresh_from_the_factory_answers_as_1():
    report = examined(("wrong_id", {"servo": 13, "value": 1}))
    assert wrong(report) == {"servo_missing", "factory_id"}
    assert "13" in the(report, "factory_id").cause


def test_a_servo_of_another_arm_is_a_stranger():
    assert "stranger" in wrong(examined(("wrong_id", {"servo": 15, "value": 16})))


def test_two_servos_with_one_id():
    report = examined(("wrong_id", {"servo": 13, "value": 12}))
    assert "duplicate_id" in wrong(report)
    assert the(report, "duplicate_id").servo == 12
    assert "13" in the(report, "duplicate_id").cause


def test_a_servo_that_answers_pings_only():
    report = examined(("silent", {"servo": 14}))
    assert wrong(report) == {"silent_reads"}
    assert the(report, "silent_reads").servo == 14


# ---- how they answer ----


def test_a_slow_latency_timer_is_found_and_a_fast_one_is_not():
    slow = examined(timed=True, latency_s=0.016)
    assert wrong(slow) == {"latency"}
    assert examined(timed=True, latency_s=0.001).healthy
    for system, word in (("linux", "latency_timer"), ("darwin", "LatencyTimer"), ("win32", "Latency Timer")):
        assert word in find("latency", system=system, ms=16, short="ttyUSB0").remedy


@pytest.mark.parametrize("servo", ARM_IDS)
@pytest.mark.parametrize("kind", ["lost", "corrupt"])
def test_occasional_failures_are_counted(kind, servo):
    report = examined((kind, {"servo": servo, "after": 8, "count": 2}))
    assert wrong(report) == {kind}
    assert the(report, kind).servo == servo


def test_answers_that_nobody_asked_for():
    report = examined(("duplicated", {"servo": 12, "after": 6, "count": 4}))
    assert wrong(report) == {"strays"}


# ---- what they are, and how ----


def test_another_model():
    report = examined(("wrong_model", {"servo": 14, "value": 1060}))
    assert wrong(report) == {"wrong_model"}
    assert "1060" in the(report, "wrong_model").symptom


def test_old_firmware():
    assert wrong(examined(("old_firmware", {"servo": 11}))) == {"old_firmware"}


@pytest.mark.parametrize("kind", ["overload", "shock", "encoder", "overheated"])
def test_hardware_errors_are_decoded(kind):
    report = examined((kind, {"servo": 12}))
    assert wrong(report) == {"hardware_error"}
    assert kind.removeprefix("over")[:4] in the(report, "hardware_error").symptom + the(report, "hardware_error").cause


@pytest.mark.parametrize(("volts", "key"), [(9.8, "low_voltage"), (10.6, "weak_voltage")])
def test_a_weak_supply(volts, key):
    assert key in wrong(examined(("low_voltage", {"value": volts})))


@pytest.mark.parametrize(("degrees", "key"), [(75.0, "hot"), (63.0, "warm")])
def test_a_hot_servo(degrees, key):
    report = examined(("hot", {"servo": 13, "value": degrees}))
    assert wrong(report) == {key}
    assert the(report, key).servo == 13


def test_an_arm_that_would_move_at_full_speed():
    fresh = VirtualArm(settings={servo: {"torque_enable": 1} for servo in JOINT_IDS})
    assert wrong(examined(arm=fresh)) == {"full_speed"}
    timed = VirtualArm(settings={servo: {"drive_mode": 4, "torque_enable": 1} for servo in JOINT_IDS})
    report = examined(arm=timed)
    assert wrong(report) == {"full_speed"}
    assert "profile velocity is 0" in report.findings[0].symptom + str(report)


def test_an_inverted_gripper_is_a_note_and_a_reversed_joint_a_warning():
    report = examined(("drive_mode", {"servo": 15, "value": 5}))
    assert report.healthy
    assert "gripper_inverted" in report.keys
    assert "joint_reversed" in wrong(examined(("drive_mode", {"servo": 12, "value": 5})))


@pytest.mark.parametrize("quarter", [1, -1])
def test_a_joint_that_is_off_by_90_degrees_is_found_with_the_true_pose(quarter):
    home = [math.degrees(a) for a in omx.HOME]
    report = examined(("horn", {"servo": 13, "value": quarter * math.pi / 2}), pose=home)
    found = the(report, "joint_off")
    assert (found.servo, "quarter turn" in found.cause) == (13, True)
    assert f"{-90 * quarter:+d}" in found.remedy
    assert examined(pose=home).healthy


def test_a_pose_that_no_arm_can_take_needs_no_help():
    report = examined(("horn", {"servo": 12, "value": -math.pi / 2}))
    assert "impossible_pose" in wrong(report)
    assert "joint 2" in the(report, "impossible_pose").symptom


def test_a_homing_offset():
    report = examined(arm=VirtualArm(settings={12: {"homing_offset": 512}}))
    assert "homing_offset" in wrong(report)
    assert "45.0" in the(report, "homing_offset").symptom


LEFT_BEHIND = {
    "narrow_limits": {"max_position_limit": 2500},
    "low_pwm_limit": {"pwm_limit": 100},
    "no_shutdown": {"shutdown": 0},
    "high_heat_limit": {"temperature_limit": 100},
    "low_heat_limit": {"temperature_limit": 60},
    "secondary_id": {"secondary_id": 12},
    "starts_by_itself": {"startup_configuration": 1},
    "weak_pwm": {"goal_pwm": 0},
    "gains": {"position_i_gain": 100},
    "joint_reversed": {"drive_mode": 5},
    "homing_offset": {"homing_offset": -400},
}


@pytest.mark.parametrize("key", LEFT_BEHIND)
def test_what_another_program_left_behind_is_known_to_the_doctor_and_refused_or_set_back_by_the_robot(key, caplog):
    arm = VirtualArm()
    for name, value in LEFT_BEHIND[key].items():
        arm.servo(13).table.put(name, value)
    assert key in wrong(examined(arm=arm))
    (row,) = [row for row in CONDITIONS if row.key == key]
    port = VirtualPort(arm, clock=SteppedClock())
    if row.level == "fault" and row.mend is None:
        with pytest.raises(errors.NotReady, match="servo 13"):
            Robot(port)
        return
    robot = Robot(port)
    if row.mend is None:
        assert "servo 13" in caplog.text  # said at once
    robot.write_motor_state(True)
    if row.mend is not None:
        assert "set back: servo 13" in caplog.text
        assert key not in doctor(robot).keys
    robot.move_to([10, -50, 20, 30])
    robot.close()


def test_each_servo_condition_is_one_row_for_the_robot_and_the_doctor():
    assert all(ILLNESSES[row.key] is row for row in CONDITIONS)


def test_a_velocity_limit_is_a_note():
    report = examined(arm=VirtualArm(settings={13: {"velocity_limit": 5}}))
    assert report.healthy
    assert "7 deg/s" in the(report, "velocity_limit").symptom


def test_a_tripped_watchdog():
    arm = VirtualArm(settings={12: {"drive_mode": 4, "profile_velocity": 200, "torque_enable": 1, "bus_watchdog": 1}})
    arm.advance(1.0)
    assert "watchdog" in wrong(examined(arm=arm))


def test_several_illnesses_are_all_found():
    report = examined(("dead", {"servo": 14}), ("hot", {"servo": 11}), ("low_voltage", {"value": 10.5}),
                      ("wrong_model", {"servo": 15}))  # fmt: skip
    assert wrong(report) >= {"servo_missing", "hot", "weak_voltage", "wrong_model"}


def test_what_several_servos_share_is_told_once_in_the_order_of_their_ids():
    told = str(examined(("low_voltage", {"value": 10.5}))).splitlines()
    first = next(i for i, line in enumerate(told) if "has only" in line)
    assert f"each of the servos {', '.join(map(str, ARM_IDS))} has only" in told[first]
    assert told[first + 1].strip().startswith("why:")
    told = str(examined(("hot", {"servo": 13, "value": 75}), ("hot", {"servo": 11, "value": 70}))).splitlines()
    first = next(i for i, line in enumerate(told) if "servo 11" in line)
    assert "servo 13" in told[first + 1], "numbers of their own, a line of their own"


# ---- the SDK ----


def installed(folder, name, version, files):
    """An installed distribution, as pip leaves it behind."""
    info = folder / f"{name.replace('-', '_')}-{version}.dist-info"
    info.mkdir()
    (info / "METADATA").write_text(f"Metadata-Version: 2.1\nName: {name}\nVersion: {version}\n")
    (info / "RECORD").write_text("".join(f"{file},,\n" for file in files))
    for file in files:
        (folder / file).parent.mkdir(exist_ok=True)
        (folder / file).write_text("")


def software(folder):
    report = Report()
    examine_software(report, [str(folder)])
    return report


def test_an_sdk_that_is_absent_old_or_right(tmp_path):
    assert wrong(software(tmp_path)) == {"sdk_missing"}
    installed(tmp_path, "dynamixel-sdk", "3.8.4", ["dynamixel_sdk/__init__.py"])
    assert wrong(software(tmp_path)) == {"sdk_old"}


def test_an_sdk_that_dynamixel_controller_brings_too(tmp_path):
    installed(tmp_path, "dynamixel-sdk", "4.1.0", ["dynamixel_sdk/__init__.py"])
    assert software(tmp_path).healthy
    installed(tmp_path, "dynamixel-controller", "0.5.1", ["dynamixel_sdk/__init__.py"])
    report = software(tmp_path)
    assert wrong(report) == {"sdk_shadowed"}
    assert "pip uninstall dynamixel-controller" in the(report, "sdk_shadowed").remedy


def test_an_sdk_that_was_written_over(tmp_path):
    """The files of the SDK of this very environment, one of them replaced by another's."""
    sdk = importlib.metadata.distribution("dynamixel-sdk")
    for file in sdk.files:
        source, target = Path(file.locate()), tmp_path / str(file)
        if source.exists() and ".." not in str(file):
            target.parent.mkdir(parents=True, exist_ok=True)
            shutil.copy(source, target)
    assert software(tmp_path).healthy
    (tmp_path / "dynamixel_sdk" / "port_handler.py").write_text("# an old copy\n")
    report = software(tmp_path)
    assert wrong(report) == {"sdk_shadowed"}
    assert "port_handler" in the(report, "sdk_shadowed").symptom


# ---- the command ----


def test_the_command_says_by_its_exit_status_whether_all_is_well(capsys):
    assert main(["--virtual"]) == 0
    assert "Nothing to mend." in capsys.readouterr().out
    assert main(["--virtual", "--fault", "broken_chain servo=13"]) == 1
    assert "between servo 12 and servo 13" in capsys.readouterr().out
    assert main(["--virtual", "--fault", "nonsense"]) == 2


def test_the_command_runs_as_a_program():
    command = [sys.executable, "-m", "omx.hardware.doctor", "/dev/nowhere"]
    done = subprocess.run(command, capture_output=True, text=True, timeout=60, check=False)
    assert done.returncode == 1
    assert "there is no port /dev/nowhere" in done.stdout
