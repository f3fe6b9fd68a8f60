"""Wiring."""
from drafting.sheet import Sheet
from drafting.style import COILS, SMALL


PIN_ROWS = (  # signals of pins.h, name, what they are wired to [firmware/README.md, "Wiring"]
    ("EmergencyStop", "emergency stop", "S1 to ground, 1 kohm; 4.7 kohm to 3.3 V"),
    ("HallSelectOff", "sensors: select", "74HC138 /E1; 10 kohm to 3.3 V"),
    ("HallAddress0", "sensors: A0", "74HC138 A0"),
    ("HallAddress1", "sensors: A1", "74HC138 A1"),
    ("HallAddress2", "sensors: A2", "74HC138 A2"),
    ("HallClock", "sensors: clock", "SCL of eight LIS3MDL"),
    ("HallOut", "sensors: out", "SDA of eight LIS3MDL"),
    ("HallIn", "sensors: in", "SDO of eight LIS3MDL"),
    ("CurrentClock", "I2C clock", "SCL of four INA260; 1 kohm to 3.3 V"),
    ("CurrentData", "I2C data", "SDA of four INA260; 1 kohm to 3.3 V"),
    ("FanPwm", "fan: PWM", "fan"),
    ("FanTach", "fan: tachometer", "fan; 4.7 kohm to 3.3 V"),
)


def draw(facts):
    s = Sheet(facts, "wiring")
    s.title_block("Wiring", "firmware: pins.h, README.md; build.toml: supply")
    pin = facts.names["firmware"].pin

    def say(name, formula, text, digits=2):
        return text.format(f"{s.size(name, formula, ''):.{digits}f}".rstrip("0").rstrip("."))

    def box(x, y, width, height, *lines):
        s.rect("edge", x, y, width, height, "box")
        for i, words in enumerate(lines):
            s.text(x + width / 2, y + height - 4.4 - 4.6 * i, words, SMALL, "middle", bold=i == 0)

    def wire(*points):
        for (x0, y0), (x1, y1) in zip(points, points[1:]):
            s.line("edge", x0, y0, x1, y1)

    box(8, 162, 36, 20, "Supply", say("supply", "omni.limits.supply_V", "{} V DC"),
        say("supply: current", "build.supply.supply_A", "{} A"))
    box(60, 162, 34, 20, "K1 contact", "main pole", say("contact of K1", "build.supply.contact_A", "{} A DC"))
    wire((44, 172), (60, 172))
    wire((94, 172), (102, 172))
    wire((102, 182), (102, 118))
    for k, address in enumerate(("40h", "41h", "44h")):
        y = (174, 142, 110)[k]
        wire((102, y + 8), (108, y + 8))
        box(108, y, 24, 16, f"F{k + 1} fuse", say(f"fuse F{k + 1}", "build.supply.fuse_A", "{} A"))
        wire((132, y + 8), (146, y + 8))
        wire((139, y + 8), (139, y - 1))
        s.line("edge", 136, y - 1, 142, y - 1)
        s.line("edge", 136, y - 2.2, 142, y - 2.2)
        s.text(135, y - 5.2, say(f"capacitor of bridge {k}", "build.supply.capacitor_F * 1e6", "{} \u00b5F"), SMALL,
               "end")
        wire((139, y - 2.2), (139, y - 5))
        s.line("edge", 137, y - 5, 141, y - 5)
        box(146, y - 5, 48, 26, f"Bridge {k}: G2 18v17",
            f"PWM {pin[f'BridgePwm{k}']}, DIR {pin[f'BridgeDirection{k}']}", f"SLP {pin[f'BridgeAwake{k}']}",
            f"FLT {pin[f'CoilFault{k}']}, with ALERT")
        s.text(196, y + 13.5, "A", SMALL)
        wire((194, y + 11), (204, y + 11))
        box(204, y, 34, 20, f"INA260 {address}", "in series with the", "coil, current only")
        wire((238, y + 11), (250, y + 11))
        box(250, y - 4, 38, 24, f"Coil {k} ({COILS[k]})",
            say(f"coil {COILS[k]}: R at 20 C", f"omni.coils[{k}].resistance_20C_ohm", "{} ohm", digits=3),
            say(f"coil {COILS[k]}: L", f"inductance_H({k}) * 1e3", "{} mH"))
        wire((194, y - 3), (250, y - 3))
        s.text(196, y - 1.8, "B", SMALL)
    box(60, 124, 34, 20, "INA260 45h", "voltage of the", "rail, no current")
    wire((94, 134), (102, 134))
    box(8, 124, 36, 20, "12 V converter", "fan, coil of K1", "before K1")
    wire((26, 162), (26, 144))
    box(8, 88, 52, 26, "S1 emergency stop", "two contacts, both closed", "1: coil of K1 to 12 V",
        f"2: pin {pin['EmergencyStop']} to ground")
    wire((26, 124), (26, 114))
    for (x0, y0), (x1, y1) in (((52, 114), (52, 152)), ((52, 152), (77, 152)), ((77, 152), (77, 162))):
        s.line("hidden", x0, y0, x1, y1)
    s.text(54, 154, "coil of K1", SMALL)
    s.notes(66, 104, "All minus wires meet in", "one point at the supply.", step=4.6)
    s.notes(66, 93, "Teensy 4.0: from USB; its", "3.3 V: sensors, INA260.", step=4.6)
    rows = [(words, str(pin[name]), to) for name, words, to in PIN_ROWS]
    for i, (words, number_of, to) in enumerate([("signal", "pin", "wired to"), *rows]):
        y, bold = 80 - 4.7 * i, i == 0
        s.text(8, y, words, SMALL, bold=bold)
        s.text(54, y, number_of, SMALL, "end", bold=bold)
        s.text(60, y, to, SMALL, bold=bold)
    s.text(160, 80, "Each bridge", SMALL, bold=True)
    s.notes(160, 75.3, "PWM: 10 kohm to ground.",
            "SLP: 100 ohm in series; behind it 10 kohm and 4.7 \u00b5F to ground.",
            "FLT and ALERT of its INA260 together: 4.7 kohm to 3.3 V.", step=4.7)
    s.notes(160, 58, "74HC138: outputs Y0 to Y7 select sensors 0 to 7 (CS).",
            "Motor current: 2.5 mm\u00b2 from fuse to coil.", step=4.7)
    return s
