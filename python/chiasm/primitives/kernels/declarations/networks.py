"""Layers of networks, and their results."""

from ..registry import declare

#: For convolutions: the window's stride and first position, the dilation, and the result's size.
_WINDOWS = (
    *(f"1 <= {name} <= INT32_MAX" for name in ("stride_y", "stride_x", "dilation_y", "dilation_x")),
    *(f"0 <= {name} <= INT32_MAX" for name in ("top", "left", "height", "width")),
    "1 <= KH <= INT32_MAX",
    "1 <= KW <= INT32_MAX",
)
declare(
    """packed_convolution(T[B, H, W, C] x, T[P, KH, KW, G, 16] weight, T[N] bias, int stride_y, int stride_x,
    int top, int left, int dilation_y, int dilation_x, int height, int width, float low, float high)
    -> T[B, height, width, N]""",
    "convolution.cpp",
    """Convolution in C / G groups of channels, with zeros outside the image, limited to low and high. The
    weights of a group's outputs are in panels of 16; the last one is padded with zeros.""",
    [
        "1 <= C",
        "1 <= G",
        "C % G == 0",
        "1 <= N",
        "N % (C // G) == 0",
        "P == C // G * ((N // (C // G) + 15) // 16)",
        *_WINDOWS,
    ],
    exact=False,
)
declare(
    """depthwise_convolution(T[B, H, W, C] x, T[KH, KW, C] weight, T[C] bias, int stride_y, int stride_x,
    int top, int left, int dilation_y, int dilation_x, int height, int width, float low, float high)
    -> T[B, height, width, C]""",
    "convolution.cpp",
    "Convolution of each channel with its own window, with zeros outside the image, limited to low and high.",
    [*_WINDOWS],
    exact=False,
)
declare(
    """lstm(T[L, B, G] gates, T[P, H, 16] weight, T[B, H] hidden, T[B, H] cell, bool reverse)
    -> T[2, L, B, H]""",
    "recurrent.cpp",
    """The steps of an LSTM layer, in reverse order if asked: hidden states and cells. `gates` has what the
    inputs and biases add to the input, forget, cell and output gates; the weights of the hidden state are in
    panels of 16 outputs, the last one padded with zeros.""",
    ["1 <= H", "G == 4 * H", "P == (G + 15) // 16"],
    tried=[("weight", -1, 1)],  # large ones multiply a rounding error at each step
    exact=False,
)
declare(
    """gru(T[L, B, G] gates, T[P, H, 16] weight, T[G] bias, T[B, H] hidden, bool reverse) -> T[L, B, H]""",
    "recurrent.cpp",
    """The steps of a GRU layer, in reverse order if asked: hidden states. `gates` has what the inputs add to
    the reset, update and new gates, with the inputs' biases; weight and bias are of the hidden state, in
    panels as for `lstm`.""",
    ["1 <= H", "G == 3 * H", "P == (G + 15) // 16"],
    tried=[("weight", -1, 1)],  # large ones multiply a rounding error at each step
    exact=False,
)
