"""Paper, letters, lines and colours; how numbers are written."""
PAPER = (297, 210)  # A4, mm
TEXT, SMALL = 3.6, 3.2  # height of letters, mm on the sheet: 11 and 10 pixels where the sheet is 900 wide

# Style -> colour [Okabe & Ito], width, dashes, colour number and line type of a DXF's layer.
STYLES = {
    "edge": ("#222222", 0.45, "", 7, "CONTINUOUS"),
    "thin": ("#555555", 0.2, "", 8, "CONTINUOUS"),
    "centre": ("#777777", 0.2, "5 1 0.8 1", 9, "CENTER"),
    "hidden": ("#222222", 0.25, "1.8 1", 8, "HIDDEN"),
    "size": ("#0072b2", 0.2, "", 5, "CONTINUOUS"),
    "text": ("#222222", 0.2, "", 7, "CONTINUOUS"),
    "coil-x": ("#d55e00", 0.3, "", 30, "CONTINUOUS"),
    "coil-y": ("#009e73", 0.3, "", 3, "CONTINUOUS"),
    "coil-z": ("#0072b2", 0.3, "", 4, "CONTINUOUS"),
    "mark": ("#d55e00", 0.45, "", 1, "CONTINUOUS"),
}
FILL = {"coil-x": "#f7d9c4", "coil-y": "#c9ebe0", "coil-z": "#cde3f2", "wall": "#dddddd", "box": "#f6f6f6",
        "iron": "#c9c9c9", "paper": "#ffffff", "accent": "#0072b2"}
COILS = "xyz"


def number(value):
    text = f"{value:.3f}".rstrip("0").rstrip(".")
    return "0" if text == "-0" else text


def label(value):
    return f"{value:.2f}".rstrip("0").rstrip(".").replace("-", "\u2212")
