"""Two users of a JupyterHub in two browsers at once: each page shows its own user's arm, through hub and proxy."""

import json

import numpy as np
import pytest

import omx

ANGLES = {"ada": (30, -40, 20, 25), "ben": (-60, -20, 35, -10)}
DRAWN = "omxScene.viewer.scene_tree.find(['meshcat', 'arm', '4']).object"


def notebook(angles):
    """One cell that drives an arm to these angles (deg) and shows it."""
    lines = ["from omx.hardware.robot import Robot", "from omx.display.viewer import View", "robot = Robot()"]
    lines += ["robot.write_motor_state(True)", f"robot.move_to({angles}, seconds=3)", "View(robot.q)"]
    kernel = {"name": "python3", "display_name": "Python 3", "language": "python"}
    cell = {"cell_type": "code", "id": "arm", "metadata": {}, "source": "\n".join(lines), "outputs": []}
    return {"cells": [{**cell, "execution_count": None}], "metadata": {"kernelspec": kernel}, "nbformat": 4,
            "nbformat_minor": 5}  # fmt: skip


def enter(browser, hub, name):
    """Log in as a student does, with a notebook at home; the page."""
    hub.home(name)
    (hub.folder / name / "arm.ipynb").write_text(json.dumps(notebook(ANGLES[name])), encoding="utf-8")
    page = browser.new_context(viewport={"width": 1200, "height": 900}).new_page()
    page.goto(f"{hub.url}/hub/login")
    page.locator("#username_input").fill(name)
    page.locator("#password_input").fill("any")
    page.locator("#login_submit").click()
    return page


def run_all(page, address):
    page.wait_for_url(f"{address}**", timeout=90_000)
    page.goto(f"{address}/tree/arm.ipynb")
    page.locator(".jp-Notebook .jp-Cell").first.wait_for(timeout=90_000)
    page.get_by_text("Python 3 (ipykernel) | Idle").first.wait_for(timeout=120_000)
    page.locator(".lm-MenuBar-item", has_text="Run").click()
    page.locator(".lm-Menu-item", has_text="Run All Cells").first.click()


def test_each_page_shows_its_own_users_arm(browser, hub):
    pages = {name: enter(browser, hub, name) for name in ANGLES}
    for name, page in pages.items():
        run_all(page, f"{hub.url}/user/{name}/lab")
    for name, page in pages.items():
        page.locator(".omx-scene[data-ready] iframe").wait_for(timeout=60_000)
        frame = page.locator(".omx-scene[data-ready] iframe").element_handle().content_frame()
        tip = 1e3 * np.array(frame.evaluate(f"{DRAWN}.position.toArray()"), float)
        assert tip == pytest.approx(omx.fk(np.radians(ANGLES[name]))[:3, 3], abs=4.0)
        page.context.close()
