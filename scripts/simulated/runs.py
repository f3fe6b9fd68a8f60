"""One run: a program on Monado without our layer, with it, or with it and the twin, whose hand comes, presses, goes and returns."""
import shutil
import subprocess
import time

from simulated import given, hand, stand, table

SCENE = stand.ROOT / "tests/engines/godot/relief.glb"
PRESSED = (0.0, 0.0, 0.040)  # of the base: 10 mm below the middle of the relief, for 1.4 N: what binds to "squeeze" wants over 0.8
PRESSES = 3
PRESS_PATIENCE_s = 5
WARM_FRAMES = 9              # in three seconds
SETTLE_s = 1.0               # after a change nothing is compared for so long
CONTROLLER = "khr/simple_controller"
# mode -> what core_validation judges; in both orders the hand changes its owner both ways.
MODES = {"no layer": "above", "layer": "above", "pen first": "above", "controller first": "below"}


def now_ns():
    return time.clock_gettime_ns(time.CLOCK_MONOTONIC)


class Play:
    """A person at the twin, and what the program has been given so far."""

    def __init__(self, program, place, patience_s, words=()):
        self.program, self.place, self.patience_s, self.words = program, place, patience_s, words
        self.file = place.folder / "witness.jsonl"
        self.turns, self.changes = [], []
        self.hand, self.held = None, False
        self.process = None

    def lines(self):
        return given.read_lines(self.file) if self.file.exists() else []

    def start(self):
        argv = [word.format(built=self.place.built, run=self.place.run) for word in self.program.argv]
        environment = self.place.program_environment(self.file)
        if self.program.project:
            shutil.copytree(stand.ROOT / self.program.project, self.place.run / "project")
            environment |= self.place.display()
        self.process = self.place.start("program", [*argv, *self.words], environment, stdin=subprocess.PIPE)

    def alive(self):
        return self.process.poll() is None

    def wait(self, condition, what):
        """False, and noted, if the program ends or it takes too long. Meanwhile a pen that is there circles in the air: one that rests
        for 20 s counts as put down."""
        def over():
            if self.hand and self.held:
                self.hand.aim(hand.circling(time.monotonic()))
            return condition() or not self.alive()
        if stand.wait_until(over, self.patience_s, 0.1) and self.alive():
            return True
        self.changes.append({"missed": what if self.alive() else f"{what}: the program has ended ({self.process.returncode})"})
        return False

    def owner(self):
        """Whose profile the right hand has."""
        found = given.profiles(self.lines(), "right")
        return {"none": None, CONTROLLER: "controller"}.get(found[-1], "pen") if found else None

    def turn_to(self, owner, act=lambda: None):
        """Acts, waits until the program knows that the hand is `owner`'s, and keeps it there for a while."""
        begin = now_ns()
        act()
        if not self.wait(lambda: self.owner() == owner, f"the hand was not the {owner}'s"):
            return False
        seen = given.of(self.lines(), "profile", hand="right")[-1]["t"]
        self.changes.append({"to": owner, "s": round(1e-9 * (seen - begin), 2)})
        time.sleep(SETTLE_s)
        self.turns.append({"owner": owner, "from": now_ns(), "to": None})
        time.sleep(1.0)
        return True

    def end_turn(self):
        if self.turns and self.turns[-1]["to"] is None:
            self.turns[-1]["to"] = now_ns()

    def come(self):
        self.held = True
        self.hand.aim(hand.ABOVE)

    def press(self):
        """Down onto the relief and up again, as a person does: until the program shows that it noticed, but not for ever."""
        for _ in range(PRESSES):
            before = given.presses(self.lines(), self.program.select)
            self.hand.move(hand.ABOVE, PRESSED, 0.7)
            stand.wait_until(lambda: given.presses(self.lines(), self.program.select) > before, PRESS_PATIENCE_s)
            time.sleep(0.5)
            self.hand.move(PRESSED, hand.ABOVE, 0.7)
            stand.wait_until(lambda: not given.is_pressed(self.lines(), self.program.select), PRESS_PATIENCE_s)
            time.sleep(0.5)

    def warm(self, fewest=WARM_FRAMES, during_s=3):
        """Waits until frames come regularly: the first ones take seconds, while a driver in software compiles shaders."""
        recent = lambda: [line for line in given.of(self.lines(), "frame") if line["t"] > now_ns() - 1e9 * during_s]
        return not self.program.graphics or self.wait(lambda: len(recent()) >= fewest, "frames did not come regularly")

    def stop_service(self):
        self.held = False
        self.place.stop_service()

    def away(self):
        self.end_turn()
        self.held = False
        self.hand.away()


def pen_first(play):
    play.hand = play.place.start_service()
    play.come()
    time.sleep(2.0)
    play.start()
    if play.warm() and play.turn_to("pen"):
        play.press()
        if play.turn_to("controller", play.away):
            play.end_turn()
            play.turn_to("pen", play.come)
    play.end_turn()


def controller_first(play):
    play.start()
    if play.warm() and play.turn_to("controller"):
        play.hand = play.place.start_service()
        time.sleep(2.0)
        play.end_turn()
        if play.turn_to("pen", play.come):
            play.press()
            play.end_turn()
            play.turn_to("controller", play.stop_service)
    play.end_turn()


def alone(play):
    play.start()
    play.warm() and play.turn_to("controller")
    time.sleep(3.0)
    play.end_turn()


def run(program, mode, root, built, folder, patience_s=120):
    """A row of the table. The program ends last, so that its last frames are seen."""
    with stand.Stand(root, built, folder, MODES[mode], mode != "no layer") as place:
        place.write_settings("*", SCENE)
        place.start_monado()
        play = Play(program, place, patience_s)
        try:
            {"pen first": pen_first, "controller first": controller_first}.get(mode, alone)(play)
        except (BrokenPipeError, ConnectionError) as error:
            play.changes.append({"missed": f"the twin has ended: {error}"})
        ended = not play.alive()
        stand.end_process(play.process)
        play.end_turn()
        place.stop_service()
        record = place.folder / "truth.csv"
        return row(play, program, mode, root, ended, hand.Truth(record) if record.exists() else None)


def row(play, program, mode, root, ended, truth):
    lines = play.lines()
    count, rate = given.frames(lines)
    result = {"program": program.name, "suite": root.suite, "mode": mode, "ended_by_itself": ended,
              "graphics": program.graphics, "frames": count, "frames_s": round(rate, 1), "profiles": given.profiles(lines, "right"),
              "profiles_left": given.profiles(lines, "left"), "changes": play.changes,
              "controller_off_mm": given.controller_off_mm(lines, program.poses, play.turns),
              "presses": given.presses(lines, program.select), "haptics": given.haptics(lines),
              "validation": play.place.validation, "validation_errors": play.place.validation_errors()}
    if program.project:
        result["presses_game"] = given.last_report(play.place.output("program")).get("presses")
    if truth:
        result |= given.pose_errors(lines, truth, program.poses, play.turns)
        result |= {"presses_true": truth.presses(), "pulses": hand.pulses(play.place.folder / "loop.csv")}
    result["problems"] = table.problems(result, PRESSES)
    return result
