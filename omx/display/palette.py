"""The book's colours, a line each: viewer, figures, panels and pages take them from here, JavaScript as data."""

#: A colour-blind-safe set (Okabe and Ito).
BLUE = "#0072b2"
ORANGE = "#e69f00"
GREEN = "#009e73"
PINK = "#cc79a7"
VERMILION = "#d55e00"
SKY = "#56b4e9"
#: For ghosts, paths, regions and curves; the first four are those of the four IK branches, in their order.
PALETTE = (BLUE, ORANGE, GREEN, PINK, VERMILION, SKY)

#: Words and arrows, and what stands back.
INK = "#1b1f24"
PALE = "#8a929c"

#: Red, green and blue for x, y and z, dark enough to read and different enough in grey.
AXES = ("#c8322b", "#20803a", "#1f57c3")
#: Colours by name, for those who ask for red: the book's own, told apart by everybody.
NAMES = {
    "black": INK, "white": "#ffffff", "grey": PALE, "gray": PALE, "red": AXES[0], "green": GREEN, "blue": BLUE,
    "orange": ORANGE, "pink": PINK, "vermilion": VERMILION, "sky": SKY,
}  # fmt: skip
#: What a limit refuses, and what touches.
REFUSED = "#c8102e"
