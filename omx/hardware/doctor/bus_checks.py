"""The wire: who answers, at which baud rate, how fast, and how reliably. Pings and reads only."""

import statistics

from ...arm import ARM_IDS
from ...errors import BadInput, BusCorrupt, BusTimeout, PortError
from ..dynamixel.bus import Bus, Ping, again
from .report import Report

BAUD = 1_000_000
#: The rates to try where nobody answers, the likely ones first.
OTHER_BAUDS = (57_600, 115_200, 2_000_000, 3_000_000, 4_000_000, 9_600, 4_500_000)
#: Ids that other arms, or servos fresh from the factory, have.
STRANGERS = (1, 2, 3, 4, 5, 10, 16, 17, 21)
SLOW_S = 0.008
ROUNDS = 25
_DAMAGED = Ping(0, 0)  # someone answered, but not even the ping came whole


def who_answers(bus: Bus, report: Report) -> dict[int, Ping]:
    """The servos of the arm that answer at 1 Mbps; what is missing, and where it is instead, goes to the report."""
    found = {servo: ping for servo in ARM_IDS if (ping := _ping(bus, servo))}
    missing = [servo for servo in ARM_IDS if servo not in found]
    elsewhere = _at_other_bauds(bus, missing) if missing else {}
    for baud, ids in elsewhere.items():
        report.add("other_baud", ids[0], ids=_listed(ids), baud=baud)
    missing = [servo for servo in missing if not any(servo in ids for ids in elsewhere.values())]
    strangers = _strangers(bus, report, missing)
    if not found and not elsewhere and not strangers:
        report.add("silent", port=bus.name)
    elif missing:
        _missing(report, found, missing)
    if found:
        report.facts.append(f"servos {_listed(found)} answer at {BAUD} baud")
    return found


def _ping(bus: Bus, servo: int) -> Ping | None:
    try:
        return again(bus.ping, servo, times=3)
    except BusTimeout:
        return None
    except BusCorrupt:
        return _DAMAGED


def _at_other_bauds(bus: Bus, missing) -> dict[int, list[int]]:
    """Which of the missing answer at another rate; the line is put back to 1 Mbps in the end."""
    found = {}
    try:
        for baud in OTHER_BAUDS if "://" not in bus.name else ():
            try:
                bus.tune(baud)
            except (BadInput, PortError):  # this adapter does not know the rate
                continue
            if ids := list(bus.scan([*missing, 1])):
                found[baud] = ids
            if set(missing) <= {servo for ids in found.values() for servo in ids}:
                break
    finally:
        bus.tune(BAUD)
    return found


def _strangers(bus: Bus, report: Report, missing) -> list[int]:
    there = list(bus.scan(STRANGERS))
    for servo in there:
        report.add("factory_id" if servo == 1 else "stranger", servo, missing=_listed(missing) or "none")
    return there


def _missing(report: Report, found, missing) -> None:
    first = ARM_IDS.index(missing[0])
    if found and list(ARM_IDS[first:]) == missing:
        report.add("chain_broken", missing[0], ids=_listed(missing), before=ARM_IDS[first - 1] if first else "none")
    else:
        for servo in missing:
            report.add("servo_missing", servo)


def how_well(bus: Bus, report: Report, servos) -> list[int]:
    """Ask each servo `ROUNDS` times: times and failures. The servos that can be read go back."""
    stray, times = bus.strays, []
    lost, corrupt = dict.fromkeys(servos, 0), dict.fromkeys(servos, 0)
    for _ in range(ROUNDS):
        for servo in servos:
            if lost[servo] == corrupt[servo] == 0 or lost[servo] + corrupt[servo] < 5:  # five failures are enough
                try:
                    bus.read_block([servo])
                    times.append(bus.history[-1].seconds)
                except BusTimeout:
                    lost[servo] += 1
                except BusCorrupt:
                    corrupt[servo] += 1
    _times(bus, report, times)
    readable = [servo for servo in servos if lost[servo] + corrupt[servo] < 5]
    _failures(report, len(servos) * ROUNDS, lost, corrupt, readable)
    if bus.strays > stray:
        report.add("strays", count=bus.strays - stray)
    return readable


def _times(bus: Bus, report: Report, times) -> None:
    if not times:
        return
    typical = statistics.median(times)
    if typical > SLOW_S:
        report.add("latency", ms=1000 * typical, short=bus.name.rpartition("/")[2])
    else:
        report.facts.append(f"one question and answer take {1000 * typical:.1f} ms")


def _failures(report: Report, asked: int, lost, corrupt, readable) -> None:
    for servo in lost:
        if servo not in readable and corrupt[servo]:
            report.add("duplicate_id", servo, missing=_listed(set(ARM_IDS) - set(lost)) or "none")
        elif servo not in readable:
            report.add("silent_reads", servo)
    for key, counts in (("lost", lost), ("corrupt", corrupt)):
        bad = {servo: n for servo, n in counts.items() if n and servo in readable}
        if bad:
            report.add(key, next(iter(bad)), count=sum(bad.values()), asked=asked, ids=f"servo {_listed(bad)}")


def _listed(ids) -> str:
    return ", ".join(map(str, sorted(ids)))
