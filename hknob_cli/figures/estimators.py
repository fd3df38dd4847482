"""How the estimators look and are called in pictures: the same colour and marker everywhere."""

# Okabe & Ito's palette, which the colour-blind can tell apart; the markers tell it once more.
COLOURS = {
    "least_squares": "#D55E00",
    "least_squares_friction": "#E69F00",
    "output_error": "#0072B2",
    "output_error_friction": "#56B4E9",
    "fourth_order": "#009E73",
}
MARKERS = {
    "least_squares": "o",
    "least_squares_friction": "s",
    "output_error": "^",
    "output_error_friction": "v",
    "fourth_order": "D",
}
NAMES = {
    "least_squares": "least squares",
    "least_squares_friction": "least squares, friction",
    "output_error": "output error",
    "output_error_friction": "output error, friction",
    "fourth_order": "fourth order",
}
