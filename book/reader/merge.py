"""A new edition of a chapter with the reader's own changes: three notebooks made one, cell by cell, by their ids."""

import copy
import re

from book.chapters.cells import source, tags


def changed(mine, given):
    """Has the reader changed anything but outputs in what was given out?"""
    return [essence(cell) for cell in mine["cells"]] != [essence(cell) for cell in given["cells"]]


def essence(cell):
    return cell.get("id"), cell["cell_type"], source(cell).rstrip("\n")


def merged(mine, given, fresh):
    """The `fresh` edition, with what the reader did to the `given` one in `mine` (parsed JSON, all three).

    An answer stays as it is, unless its TODO asks for other names now: then it stands below the new TODO. Where both
    changed another cell, the new one is followed by the reader's. Cells that the reader added follow the cell that
    they followed; cells that were deleted stay away unless they are new.
    """
    own, was = by_id(mine), by_id(given)
    cells, used = [], set()
    for cell in fresh["cells"]:
        name = cell["id"]
        if name in own:
            used.add(name)
            cells += both(own[name], was.get(name), cell)
        elif name not in was or essence(was[name]) != essence(cell):
            cells.append(cell)
    place_rest(mine["cells"], was, cells, used)
    return {**fresh, "cells": cells}


def by_id(notebook):
    return {cell.get("id"): cell for cell in notebook["cells"]}


def both(own, was, fresh):
    """What stands for one cell: the fresh one, the reader's, or one after the other."""
    if essence(own) == essence(fresh):
        return [own]  # with its outputs
    if was is not None and essence(own) == essence(was):
        return [fresh]
    still_asked = "solution" in tags(fresh) and (was is None or asked(was) == asked(fresh))
    if still_asked or (was is not None and essence(was) == essence(fresh)):
        return [own]
    return [fresh, {**copy.deepcopy(own), "id": f"{own['id'][:56]}-mine"}]


def asked(todo):
    """The names that a TODO asks for: those of its functions, and those before its dots."""
    return re.findall(r"^(?:def |class )?(\w+)(?=\(| = \.\.\.)", source(todo), re.M)


def place_rest(mine, was, cells, used):
    """Put in the reader's cells that are not in `cells` yet; those that a new edition dropped unchanged go."""
    place = -1
    for cell in mine:
        name = cell.get("id")
        if name in used:
            place = max(n for n, there in enumerate(cells) if there["id"] in (name, f"{name[:56]}-mine"))
        elif name not in was or essence(cell) != essence(was[name]):
            place += 1
            cells.insert(place, cell)
