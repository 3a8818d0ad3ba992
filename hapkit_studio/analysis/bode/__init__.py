"""What a person may choose for a Bode diagram; knows nothing else, so that it loads at once."""

from hapkit_studio.parameters import Parameter

AMPLITUDE = Parameter("amplitude", "Amplitude", "m", 1e-3, 20e-6, 0.01, "The handle moves so far at most")
LINEAR = 0.9  # coherence below which a point says little
COMPARED = 0.4  # of half the rate: up to here measured and theory are compared
