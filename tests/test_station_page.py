"""The station's page in a browser: what it shows, what it sends, and when it lets go."""

from __future__ import annotations

import time
from collections.abc import Callable, Iterator
from functools import partial
from typing import Any

import numpy as np
import pytest
from browser import CHROMIUM, chromium, count_hue, needs_chromium
from page_rig import Rig
from page_rig import rig as station
from PIL import Image

from scara_drake.safety import MEANINGS, Reason, State

pytestmark = needs_chromium
PATIENCE = 30.0  # with a busy machine [s]
# A gamepad of the standard layout, whose motors note what they are told.
PAD = """
window.pad = {id: 'Test Pad (STANDARD GAMEPAD)', index: 0, connected: true, mapping: 'standard',
  timestamp: 0, axes: [0, 0, 0, 0],
  buttons: Array.from({length: 17}, () => ({pressed: false, touched: false, value: 0})),
  vibrationActuator: {playEffect: (kind, effect) => {
    window.effects.push([kind, effect.strongMagnitude, effect.weakMagnitude, effect.duration]);
    return Promise.resolve('complete'); }}};
window.effects = [];
window.plugged = true;
window.button = (index, down) => {
  pad.buttons[index] = {pressed: down, touched: down, value: +down}; };
navigator.getGamepads = () => [window.plugged ? window.pad : null, null, null, null];
"""
# Notes every input that the page sends: a short press is over before a busy test looks.
SPY = """
window.said = [];
const send = WebSocket.prototype.send;
WebSocket.prototype.send = function (text) {
  const message = JSON.parse(text);
  if (message.type === 'input') window.said.push(message);
  return send.call(this, text);
};
"""


@pytest.fixture(scope="module")
def browser() -> Iterator[Any]:
    with chromium() as one:
        yield one


@pytest.fixture(scope="module")
def plain(browser: Any) -> Iterator[Any]:
    """A browser that draws no scene: quick, and the page has to do without."""
    arguments = ["--no-sandbox", "--disable-3d-apis"]
    one = browser.browser_type.launch(executable_path=CHROMIUM, args=arguments)
    yield one
    one.close()


@pytest.fixture(scope="module")
def server() -> Iterator[Rig]:
    with station() as one:
        yield one


@pytest.fixture
def rig(server: Rig) -> Rig:
    server.supervisors((State.IDLE, Reason.RELEASED), (State.IDLE, Reason.NONE))
    server.show(f_haptic=0.0)
    return server


@pytest.fixture
def opened(browser: Any, plain: Any, rig: Rig) -> Iterator[Callable[..., Any]]:
    """Opens pages, as different people would; no error of a script goes unseen."""
    contexts, errors = [], []

    def open_one(script: str = "", size: tuple[int, int] = (920, 560), draws: bool = False) -> Any:
        viewport = {"width": size[0], "height": size[1]}
        contexts.append((browser if draws else plain).new_context(viewport=viewport))
        page = contexts[-1].new_page()
        page.set_default_timeout(1000.0 * PATIENCE)
        page.on("pageerror", lambda error: errors.append(str(error)))
        page.add_init_script(script)
        page.goto(rig.url)
        page.wait_for_selector("body[data-online=true]")
        return page

    yield open_one
    for context in contexts:
        context.close()
    assert not errors


def until(page: Any, condition: Callable[[], Any]) -> None:
    """Wait until a condition holds; the page goes on meanwhile."""
    end = time.monotonic() + PATIENCE
    while not condition():
        assert time.monotonic() < end, "it never happened"
        page.wait_for_timeout(20)


def take(page: Any) -> None:
    page.click("#take")
    page.wait_for_selector("body[data-mine=true]")


def shows(page: Any, selector: str, words: str) -> None:
    page.locator(selector).get_by_text(words).first.wait_for()


def is_down(rig: Rig, name: str) -> bool:
    return rig.buttons()[name]


def is_up(rig: Rig, name: str) -> bool:
    return not rig.buttons()[name]


def was_said(page: Any, name: str) -> bool:
    return bool(page.evaluate("name => said.some((one) => one.buttons[name])", name))


def test_the_gamepad_drives_and_its_motors_shake(rig: Rig, opened: Callable[..., Any]) -> None:
    page = opened(PAD)
    take(page)
    page.evaluate("button(5, true); pad.axes = [0.5, -1, 0, 0.25]")
    until(page, lambda: rig.buttons()["engage"] and rig.axes()["y"] == -1.0)
    axes = rig.axes()
    assert 0.4 < axes["x"] < 0.5  # the dead zone is taken off
    assert -0.25 < axes["z"] < -0.1  # stick down is down
    page.evaluate("button(7, true); button(13, true)")
    until(page, lambda: rig.axes()["mast_axis"] == 1.0 and rig.axes()["mast_hat"] == -1.0)
    assert page.evaluate("effects") == []
    rig.device.rumble(0.75, 0.25, 400)
    until(page, lambda: page.evaluate("effects.length") > 1)
    assert page.evaluate("effects[0]") == ["dual-rumble", 0.75, 0.25, 150]
    until(page, lambda: page.evaluate("effects.at(-1)[1]") == 0)  # it stops by itself
    shows(page, "#source", "Test Pad")


def test_a_control_far_from_rest_counts_only_after_it_has_been_near(
    rig: Rig, opened: Callable[..., Any]
) -> None:
    page = opened(PAD + "pad.axes = [-1, 0, 0, 0]; button(7, true); button(5, true);")
    take(page)
    page.evaluate("pad.axes = [-1, 0.5, 0, 0]")
    until(page, lambda: rig.axes()["y"] > 0.4)
    assert rig.axes()["x"] == rig.axes()["mast_axis"] == 0.0
    assert not rig.buttons()["engage"]
    page.evaluate("pad.axes = [0, 0, 0, 0]; button(5, false)")
    until(page, lambda: rig.axes()["y"] == 0.0)
    page.evaluate("pad.axes = [-1, 0, 0, 0]; button(5, true)")
    until(page, lambda: rig.axes()["x"] == -1.0 and rig.buttons()["engage"])


def test_a_gamepad_that_is_gone_lets_go_at_once_and_plugging_it_in_is_not_enough(
    rig: Rig, opened: Callable[..., Any]
) -> None:
    page = opened(PAD)
    take(page)
    page.evaluate("button(5, true); pad.axes = [1, 0, 0, 0]")
    until(page, lambda: rig.buttons()["engage"])
    page.evaluate("plugged = false")
    until(page, lambda: not rig.buttons()["engage"])
    shows(page, "#log", "Test Pad is gone: engage released")
    page.evaluate("plugged = true; pad.axes = [0, 0.3, 0, 0]")  # the button is still down
    until(page, lambda: rig.axes()["y"] > 0.2)
    assert not rig.buttons()["engage"]
    page.evaluate("button(5, false)")
    page.wait_for_function(
        "() => document.querySelector('#engage').classList.contains('down') === false"
    )
    page.wait_for_timeout(100)  # it has to be seen up
    page.evaluate("button(5, true)")
    until(page, lambda: rig.buttons()["engage"])


def test_the_keyboard_moves_gently_and_lets_go(rig: Rig, opened: Callable[..., Any]) -> None:
    page = opened(SPY)
    take(page)
    page.keyboard.down("Space")
    page.keyboard.down("KeyD")
    until(page, lambda: rig.buttons()["engage"] and rig.axes()["x"] == 0.6)
    steps = np.diff(page.evaluate("said.map((one) => one.axes[0])"))
    assert 0.0 <= steps.min() <= steps.max() <= 0.31  # 3 a second, at most 0.1 s at once
    page.keyboard.up("KeyD")
    until(page, lambda: rig.axes()["x"] == 0.0)
    page.keyboard.up("Space")
    until(page, lambda: not rig.buttons()["engage"])
    page.keyboard.press("Escape")
    until(page, lambda: was_said(page, "estop"))
    until(page, lambda: not rig.buttons()["estop"])
    page.keyboard.down("Space")
    until(page, lambda: rig.buttons()["engage"])
    page.evaluate("dispatchEvent(new Event('blur'))")  # another window has the keys now
    until(page, lambda: not rig.buttons()["engage"])


def test_the_stick_on_the_screen_and_its_buttons(rig: Rig, opened: Callable[..., Any]) -> None:
    page = opened(SPY)
    take(page)
    box = page.locator("#stick").bounding_box()
    x, y = box["x"] + box["width"] / 2, box["y"] + box["height"] / 2
    page.mouse.move(x, y)
    page.mouse.down()
    page.mouse.move(x + box["width"], y - box["height"] / 4)
    until(page, lambda: rig.axes()["x"] == 1.0 and -0.7 < rig.axes()["y"] < -0.5)
    page.mouse.up()
    until(page, lambda: rig.axes()["x"] == rig.axes()["y"] == 0.0)
    for name in ("engage", "clutch"):  # held
        page.hover(f"#{name}")
        page.mouse.down()
        until(page, partial(is_down, rig, name))
        page.mouse.up()
        until(page, partial(is_up, rig, name))
    for name in ("hold", "reset", "estop"):  # for a moment
        page.click(f"#{name}")
        until(page, partial(was_said, page, name))
        until(page, partial(is_up, rig, name))


def test_sliders_act_and_follow(rig: Rig, opened: Callable[..., Any]) -> None:
    page, other = opened(), opened()
    take(page)
    page.fill("#set-force_scale", "0.5")
    page.fill("#set-delay_up", "0.25")
    until(page, lambda: rig.settings()["force_scale"] == 0.5 and rig.settings()["delay_up"] == 0.25)
    shows(page, "output[for=set-delay_up]", "250")
    until(other, lambda: other.input_value("#set-delay_up") == "0.25")
    assert other.is_disabled("#set-delay_up")
    page.fill("#set-delay_up", "0")
    page.fill("#set-force_scale", "1")
    until(page, lambda: rig.settings()["force_scale"] == 1.0)


def test_a_second_page_watches_and_cannot_command_until_it_is_given_control(
    rig: Rig, opened: Callable[..., Any]
) -> None:
    holder, watcher = opened(), opened()
    take(holder)
    watcher.wait_for_selector("#take:disabled")
    assert watcher.is_disabled("#engage")
    assert watcher.is_disabled("#estop")
    watcher.keyboard.down("Space")
    watcher.keyboard.down("KeyD")
    # Whatever its scripts say, the server does not listen.
    watcher.evaluate("""() => new Promise((done) => { const socket = new WebSocket('ws');
      socket.onmessage = ({data}) => typeof data === 'string' && JSON.parse(data).type === 'refused'
        && done(socket.close());
      socket.onopen = () => socket.send(JSON.stringify({type: 'input', axes: [1, 0, 0, 0, 0],
        buttons: {engage: true}})); })""")
    holder.keyboard.down("KeyW")
    until(holder, lambda: rig.axes()["y"] == -0.6)
    assert rig.axes()["x"] == 0.0
    assert not rig.buttons()["engage"]
    holder.keyboard.up("KeyW")
    holder.get_by_role("button", name="Give control").first.click()
    watcher.wait_for_selector("body[data-mine=true]")
    holder.wait_for_selector("body[data-mine=false]")
    until(watcher, lambda: rig.axes()["x"] == 0.6)
    assert not rig.buttons()["engage"]  # Space was down before: it has to be pressed anew
    watcher.keyboard.up("Space")
    watcher.wait_for_timeout(100)
    watcher.keyboard.down("Space")
    until(watcher, lambda: rig.buttons()["engage"])


def test_closing_the_page_is_a_device_that_is_lost(rig: Rig, opened: Callable[..., Any]) -> None:
    page, other = opened(), opened()
    take(page)
    page.keyboard.down("Space")
    until(page, lambda: rig.buttons()["engage"] and rig.connected())
    page.close()
    until(other, lambda: not rig.connected())
    other.wait_for_selector("#take:enabled")  # and it does not take control by itself
    assert other.get_attribute("body", "data-mine") == "false"


def test_a_hidden_page_lets_go(rig: Rig, opened: Callable[..., Any]) -> None:
    page = opened(PAD)
    take(page)
    page.evaluate("button(5, true)")
    until(page, lambda: rig.buttons()["engage"])
    hide = """(hidden) => { Object.defineProperty(document, 'hidden', {value: hidden,
      configurable: true}); document.dispatchEvent(new Event('visibilitychange')); }"""
    page.evaluate(hide, True)
    until(page, lambda: not rig.buttons()["engage"])
    page.evaluate(hide, False)
    shows(page, "#log", "engage released: this page was hidden")
    page.evaluate("pad.axes = [0, 1, 0, 0]")
    until(page, lambda: rig.axes()["y"] == 1.0)
    assert not rig.buttons()["engage"]


def test_each_reason_is_told_in_words_with_its_remedy(rig: Rig, opened: Callable[..., Any]) -> None:
    page = opened()
    for reason, meaning in MEANINGS.items():
        if reason == Reason.NONE:
            continue
        state = (State.ACTIVE, State.HOLD, State.FAULT, State.ESTOP)[meaning.severity]
        rig.supervisors((State.ACTIVE, Reason.NONE), (state, reason))
        name = state.name.replace("ESTOP", "E-STOP")
        told = [name, meaning.says, meaning.remedy]
        page.wait_for_function(
            "told => ['state', 'reason', 'remedy'].every("
            "(id, k) => document.getElementById(id).textContent === told[k])",
            arg=told,
        )
        assert page.get_attribute("body", "data-state") == state.name
        assert page.get_attribute("#state-shape", "href") == f"#shape-{state.name}"
    shows(page, "#log", MEANINGS[Reason.OVER_FORCE].says)


def test_a_wrong_token_sees_nothing(rig: Rig, plain: Any) -> None:
    page = plain.new_page()
    wrong = rig.url[:-3] + ("a/" if rig.url[-2] != "a" else "b/")  # in its last letter
    for name in ("", "main.js", "viewer.js", "ws"):
        assert page.request.get(wrong + name).status == 404
    assert page.goto(rig.url).status == 200
    closed = page.evaluate(
        """(url) => new Promise((done) => { const socket = new WebSocket(url);
        socket.onopen = () => done('open'); socket.onclose = () => done('closed'); })""",
        wrong.replace("http", "ws") + "ws",
    )
    assert closed == "closed"
    page.close()


@pytest.mark.slow
@pytest.mark.parametrize(("width", "height"), [(1280, 800), (390, 844)])
def test_it_fits_the_screen_and_shows_the_robot(
    rig: Rig, opened: Callable[..., Any], tmp_path: Any, width: int, height: int
) -> None:
    page = opened(size=(width, height), draws=True)
    page.wait_for_function(
        "() => document.getElementById('lag').textContent !== '-'"
    )  # it was drawn
    size = page.evaluate("""() => { const root = document.documentElement;
        return [root.scrollWidth - innerWidth, root.scrollHeight - innerHeight]; }""")
    assert size[0] <= 0
    assert size[1] <= 0 or width < 900  # on a telephone it scrolls, but not sideways
    file = tmp_path / "scene.png"
    page.locator("#scene").screenshot(path=file)
    picture = np.asarray(Image.open(file).convert("RGB"))
    assert count_hue(picture, 10.0, 45.0) > 0.01 * picture.shape[0] * picture.shape[1]  # orange


@pytest.mark.slow
def test_all_can_be_done_with_the_keyboard_and_has_a_name(opened: Callable[..., Any]) -> None:
    page = opened()
    names = page.evaluate("""() => [...document.querySelectorAll('button, input')].map((element) =>
        (element.textContent || element.labels?.[0]?.textContent || '').trim())""")
    assert len(names) > 15
    assert all(names)
    page.locator("#take").focus()
    page.keyboard.press("Enter")
    page.wait_for_selector("body[data-mine=true]")
    page.locator("#set-motion_scale").focus()
    page.keyboard.press("ArrowLeft")
    assert page.input_value("#set-motion_scale") == "0.99"


@pytest.mark.slow
def test_a_lost_server_is_told_and_its_return_engages_nobody(plain: Any) -> None:
    page = plain.new_page()
    page.set_default_timeout(1000.0 * PATIENCE)
    with station() as rig:
        page.goto(rig.url)
        take(page)
        page.keyboard.down("Space")
        until(page, lambda: rig.buttons()["engage"])
        port = int(rig.url.split(":")[2].split("/")[0])
    shows(page, "#banner", "Connection lost")
    assert page.get_attribute("body", "data-state") == "NONE"
    with station(port) as rig:  # another run, with another token
        page.goto(rig.url)
        page.wait_for_selector("body[data-online=true]")
        page.wait_for_selector("#take:enabled")
        assert not rig.connected()
        take(page)
        page.keyboard.down("KeyW")
        until(page, lambda: rig.axes()["y"] == -0.6)
        assert not rig.buttons()["engage"]
    page.close()
