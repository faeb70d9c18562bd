"""Everything the doctor knows, as rows: what is the case, why, and what to do (by system where that differs).

What is judged of a single servo is in `fault_table`, for `Robot` refuses by the same rows.
"""

from ..fault_table import CONDITIONS, Condition

_SDK = "In this folder: `python run.py lab` installs the right one; else `pip install --force-reinstall dynamixel-sdk`."
_PLUG = "Plug the adapter in with a cable that carries data"
_NO_ARM = "No arm? Then nothing is wrong: `Robot()` is virtual, and `--virtual` examines that one."


def _illness(key: str, level: str, symptom: str, cause: str, remedy: str | dict[str, str]) -> Condition:
    """A row that an examination finds, not registers alone."""
    return Condition(key, level, (), None, symptom, cause, remedy)


_ROWS = (
    # ---- software ----
    _illness("sdk_missing", "fault", "the package dynamixel-sdk is not installed",
        "this Python has not been set up",
        _SDK),
    _illness("sdk_old", "fault", "dynamixel-sdk is version {version}; 4.0.5 is the oldest that will do",
        "before, a late answer was taken for the answer to the next question",
        _SDK),
    _illness("sdk_shadowed", "fault", "the package {package} in use is not the one of {wanted}: {who}",
        "another package, dynamixel-controller for one, writes its own old copy over it",
        "Uninstall the other one, then put the right one back: `pip uninstall {rival}`, "
        "`pip install --force-reinstall {wanted}`."),
    # ---- the port ----
    _illness("no_ports", "fault", "this computer sees no USB serial port",
        "no arm is plugged in, the cable only charges, or the adapter has no driver",
        {"linux": f"{_PLUG}; `dmesg | tail` must show ttyUSB0 or ttyACM0. {_NO_ARM}",
         "darwin": f"{_PLUG}; `ls /dev/tty.usb*` must show it. {_NO_ARM}",
         "win32": f"{_PLUG}; the Device Manager must list it under Ports. For a U2D2 without a COM number install "
         f"FTDI's VCP driver. {_NO_ARM}"}),
    _illness("port_absent", "fault", "there is no port {port}",
        "the plug is out, or the system gave the adapter another name",
        {"linux": "Plug it in; `ls /dev/ttyUSB* /dev/ttyACM*` shows the names.",
         "darwin": "Plug it in; `ls /dev/tty.usb*` shows the names.",
         "win32": "Plug it in; the Device Manager shows the COM number under Ports."}),
    _illness("no_permission", "fault", "the system does not let you open {port} (error 13)",
        "your user may not use serial ports",
        {"linux": "`sudo usermod -aG dialout $USER`, then log out and in again. Never chmod 777: it opens the port "
         "to everyone, and only until the plug is pulled.",
         "darwin": "Use the name that begins with /dev/tty.usb or /dev/cu.usb; a managed Mac may forbid it.",
         "win32": "Another program has it open: close it, or pull the plug and put it back."}),
    _illness("port_busy", "fault", "{port} is in use{who}",
        "another notebook or program has it open; two at once would corrupt each other",
        {"linux": "Close that one: in JupyterLab, Kernel > Shut Down. `fuser -v {port}` shows who it is.",
         "darwin": "Close that one: in JupyterLab, Kernel > Shut Down. `lsof {port}` shows who it is.",
         "win32": "Close that one (error 5 means the same): in JupyterLab, Kernel > Shut Down."}),
    _illness("modem_manager", "warning", "ModemManager runs, and {port} looks like a modem to it",
        "for half a minute after plugging in it talks to the port",
        "Wait 30 s after plugging in; or `sudo systemctl disable --now ModemManager` if you have no mobile modem."),
    _illness("port_error", "fault", "{port} cannot be opened: {text}",
        "the system's own words are above",
        "Pull the plug, put it back, and try once more; then another USB socket and another cable."),
    _illness("port_lost", "fault", "{port} went away while it was examined",
        "the plug moved, or the adapter lost its power",
        "Put the plug back, without a hub if there is one, and fix the cable."),
    # ---- who answers ----
    _illness("silent", "fault", "{port} opens, but no servo answers at any baud rate",
        "the servos have no power or the cable is not in the right socket",
        "Is the 12 V supply on? Each servo's light flashes once when it comes on. On a U2D2 the cable of these servos "
        "goes into the TTL socket with 3 pins, not RS-485 with 4. On an OpenCR the sketch usb_to_dxl must be loaded."),
    _illness("other_baud", "fault", "servo {ids} answers at {baud} baud, not at 1000000",
        "its baud rate was changed",
        "Set it to 1 Mbps with DYNAMIXEL Wizard, torque off; or: `bus = Bus(port, {baud})`, "
        "`bus.write(ID, 'torque_enable', 0)`, `bus.write(ID, 'baud_rate', 3)`."),
    _illness("chain_broken", "fault", "servos {ids} do not answer; those before do",
        "the chain is broken where the first silent servo begins",
        "Reseat the cable between servo {before} and servo {servo}, at both ends."),
    _illness("servo_missing", "fault", "servo {servo} does not answer, though servos after it do",
        "it has another id, another baud rate, or is broken",
        "Connect it alone and look for it with DYNAMIXEL Wizard. Its light must flash when the power comes on."),
    _illness("factory_id", "fault", "a servo answers as id 1",
        "1 is the id that the factory gives: a servo was replaced or reset (missing: {missing})",
        "Connect it alone, then `bus.write(1, 'id', N)` with the missing id N and torque off."),
    _illness("stranger", "warning", "a servo answers as id {servo}, which the OpenMANIPULATOR-X does not have",
        "this is another arm (OMX-F and OMX-L have ids 11 to 16), or a servo has the wrong id (missing: {missing})",
        "Look which arm it is; a wrong id can be changed with the torque off: `bus.write({servo}, 'id', N)`."),
    _illness("duplicate_id", "fault", "nearly every answer of servo {servo} is damaged",
        "two servos have this id and speak at once (missing: {missing})",
        "Unplug the chain behind the first of them, give that one its own id, and plug it in again."),
    _illness("silent_reads", "fault", "servo {servo} answers a ping and nothing else",
        "its status return level (register 68) is 0",
        "`bus.write({servo}, 'status_return_level', 2)`, or switch the 12 V off and on."),
    # ---- how they answer ----
    _illness("latency", "warning", "one question and answer take {ms:.0f} ms; 1 to 2 ms are right",
        "the USB adapter collects bytes for its latency timer, 16 ms from the factory",
        {"linux": "`echo 1 | sudo tee /sys/bus/usb-serial/devices/{short}/latency_timer`. For good, the udev rule: "
         'ACTION=="add", SUBSYSTEM=="usb-serial", DRIVER=="ftdi_sio", ATTR{{latency_timer}}="1".',
         "darwin": "Apple's own driver has no such setting: install FTDI's VCP driver: its LatencyTimer is 1.",
         "win32": "Device Manager > Ports > the adapter > Properties > Port Settings > Advanced > Latency Timer: 1."}),
    _illness("lost", "warning", "{count} of {asked} questions got no answer ({ids})",
        "a loose cable, a weak supply, or a second program on the line",
        "Reseat the cables, first to servo {servo}; move the arm by hand meanwhile and see whether it gets worse."),
    _illness("corrupt", "warning", "{count} of {asked} answers were damaged ({ids})",
        "a loose cable, two servos with one id, or two programs on the line",
        "Close every other program that knows this port; reseat the cables, first to servo {servo}."),
    _illness("strays", "warning", "{count} answers came that nobody had asked for",
        "a second program is on the line, or two servos share an id",
        "Close every other program that knows this port."),
    # ---- how they are set ----
    _illness("impossible_pose", "fault", "the arm reads ({angles}) deg, which no arm can be: {why}",
        "a horn was screwed on a quarter turn off, or a homing offset is set",
        "Put the arm by hand where it is upright and straight, and compare: `--pose 0 0 0 0`. The joint that is off by "
        "90 degrees has its horn on wrong: unscrew it, turn it, screw it on."),
    _illness("joint_off", "fault", "joint {joint} reads {found:.1f} deg where you say {wanted:.1f}: {off:+.0f} deg",
        "{why}",
        "Torque off; unscrew the horn of servo {servo}, turn it by {back:+.0f} deg, screw it on, and ask again."),
)  # fmt: skip

ILLNESSES: dict[str, Condition] = {row.key: row for row in (*_ROWS, *CONDITIONS)}
