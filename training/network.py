"""The depth network: a MobileNetV2 encoder with batch norm folded, and a light decoder.

Encoder: the layers of MobileNetV2 (Sandler et al. 2018) up to its last bottleneck. Its values come
from a quantised TensorFlow Lite file, read and dequantised here (read_tflite, load_encoder).
Decoder: top-down sums of 1 x 1 laterals, depthwise-separable 3 x 3 convolutions and bilinear
upsampling by 2. The last step to the full size adds a difference for each of the four pixels, so
that an edge can be one pixel wide. Input: RGB, (value / 255 - 0.5) / 0.5, sides multiples of 32. Output: relative
inverse depth, [1, 1, height, width].
"""
import struct

import numpy as np
import onnx
import torch
import torch.nn.functional as F
from google.protobuf.message import DecodeError
from onnx import numpy_helper
from torch import nn

# expansion, channels, repeats, stride of the first (table 2 of the paper)
STAGES = [(1, 16, 1, 1), (6, 24, 2, 2), (6, 32, 3, 2), (6, 64, 4, 2), (6, 96, 3, 1),
          (6, 160, 3, 2), (6, 320, 1, 1)]


class Bottleneck(nn.Module):
    def __init__(self, inputs, outputs, stride, expansion):
        super().__init__()
        middle = inputs * expansion
        self.expand = nn.Conv2d(inputs, middle, 1) if expansion > 1 else None
        self.depthwise = nn.Conv2d(middle, middle, 3, stride, 1, groups=middle)
        self.project = nn.Conv2d(middle, outputs, 1)
        self.residual = stride == 1 and inputs == outputs

    def forward(self, x):
        y = F.relu(self.expand(x)) if self.expand is not None else x
        y = self.project(F.relu(self.depthwise(y)))
        return x + y if self.residual else y


class Encoder(nn.Module):
    """Features at 1/2, 1/4, 1/8, 1/16 and 1/32 of the size."""

    def __init__(self):
        super().__init__()
        self.first = nn.Conv2d(3, 32, 3, 2, 1)
        blocks, self.taps, inputs = [], [], 32
        for expansion, outputs, repeats, stride in STAGES:
            for i in range(repeats):
                if i == 0 and stride == 2:
                    self.taps.append(len(blocks) - 1)
                blocks.append(Bottleneck(inputs, outputs, stride if i == 0 else 1, expansion))
                inputs = outputs
        self.taps.append(len(blocks) - 1)
        self.blocks = nn.ModuleList(blocks)
        self.channels = [16, 24, 32, 96, 320]

    def convolutions(self):
        """All convolutions in the order of the TensorFlow Lite file."""
        yield self.first
        for block in self.blocks:
            if block.expand is not None:
                yield block.expand
            yield block.depthwise
            yield block.project

    def forward(self, x):
        x = F.relu(self.first(x))
        features = []
        for i, block in enumerate(self.blocks):
            x = block(x)
            if i in self.taps:
                features.append(x)
        return features


class Separable(nn.Module):
    """Residual: depthwise k x k, then 1 x 1."""

    def __init__(self, channels, kernel=3):
        super().__init__()
        self.depthwise = nn.Conv2d(channels, channels, kernel, 1, kernel // 2, groups=channels)
        self.pointwise = nn.Conv2d(channels, channels, 1)

    def forward(self, x):
        return x + self.pointwise(F.relu(self.depthwise(x)))


def up(x):
    return F.interpolate(x, scale_factor=2.0, mode="bilinear", align_corners=False)


class DepthNet(nn.Module):
    def __init__(self, widths=(16, 32, 48, 96, 160), repeats=(1, 1, 1, 1, 2), top=7):
        super().__init__()
        self.encoder = Encoder()
        self.lateral = nn.ModuleList(
            nn.Conv2d(c, w, 1) for c, w in zip(self.encoder.channels, widths))
        self.refine = nn.ModuleList(
            nn.Sequential(*[Separable(w, top if level == 4 else 3) for _ in range(n)])
            for level, (w, n) in enumerate(zip(widths, repeats)))
        self.narrow = nn.ModuleList(
            nn.Conv2d(widths[i + 1], widths[i], 1) for i in range(4))
        self.head = nn.Conv2d(widths[0], 1, 1)
        self.detail = nn.ConvTranspose2d(widths[0], 1, 2, 2, bias=False)
        nn.init.zeros_(self.detail.weight)

    def forward(self, x):
        features = self.encoder(x)
        y = self.refine[4](self.lateral[4](features[4]))
        for level in (3, 2, 1, 0):
            y = F.relu(up(self.narrow[level](y)) + self.lateral[level](features[level]))
            y = self.refine[level](y)
        return up(self.head(y)) + self.detail(y)


class _Table:
    """A table of a FlatBuffer: fields by number (schema of TensorFlow Lite 2.x)."""

    def __init__(self, data, at):
        self.data, self.at = data, at
        self.fields = at - struct.unpack_from("<i", data, at)[0]

    def _place(self, number):
        size = struct.unpack_from("<H", self.data, self.fields)[0]
        offset = 4 + 2 * number
        inside = struct.unpack_from("<H", self.data, self.fields + offset)[0] if offset < size else 0
        return self.at + inside if inside else None

    def scalar(self, number, form, default=0):
        place = self._place(number)
        return default if place is None else struct.unpack_from("<" + form, self.data, place)[0]

    def _target(self, number):
        place = self._place(number)
        return None if place is None else place + struct.unpack_from("<I", self.data, place)[0]

    def table(self, number):
        return _Table(self.data, self._target(number))

    def array(self, number, dtype):
        place = self._target(number)
        if place is None:
            return np.zeros(0, dtype)
        count = struct.unpack_from("<I", self.data, place)[0]
        return np.frombuffer(self.data, dtype, count, place + 4)

    def tables(self, number):
        place = self._target(number)
        count = struct.unpack_from("<I", self.data, place)[0]
        starts = range(place + 4, place + 4 + 4 * count, 4)
        return [_Table(self.data, s + struct.unpack_from("<I", self.data, s)[0]) for s in starts]


def read_tflite(file):
    """The (weights, bias) of all convolutions of a quantised file, as floats, in its order.

    Weights as PyTorch has them: [outputs, inputs, height, width], depthwise [channels, 1, ...].
    """
    with open(file, "rb") as stream:
        data = stream.read()
    model = _Table(data, struct.unpack_from("<I", data, 0)[0])
    codes = [code.scalar(0, "b") for code in model.tables(1)]
    graph, buffers = model.tables(2)[0], model.tables(4)
    tensors = graph.tables(0)

    def values(index, dtype):
        tensor = tensors[index]
        quantization = tensor.table(4)
        scale = quantization.array(2, "<f4").astype(np.float64)
        zero = quantization.array(3, "<i8").astype(np.float64)
        numbers = buffers[tensor.scalar(2, "I")].array(0, np.uint8).view(dtype)
        floats = (numbers.astype(np.float64) - (zero[0] if len(zero) else 0)) * scale[0]
        return floats.astype(np.float32).reshape(tensor.array(0, "<i4"))

    convolutions = []
    conv_2d, depthwise_conv_2d = 3, 4
    for operator in graph.tables(3):
        code = codes[operator.scalar(0, "I")]
        if code not in (conv_2d, depthwise_conv_2d):
            continue
        _, weights, bias = operator.array(1, "<i4")
        # conv_2d: outputs, height, width, inputs; depthwise: 1, height, width, channels
        order = (0, 3, 1, 2) if code == conv_2d else (3, 0, 1, 2)
        convolutions.append((values(weights, np.uint8).transpose(order), values(bias, "<i4")))
    return convolutions


def load_encoder(encoder, file):
    """Fills the encoder from a quantised MobileNetV2 1.0. Returns the classifier's two layers."""
    read = read_tflite(file)
    own = list(encoder.convolutions())
    for convolution, (weights, bias) in zip(own, read):
        assert convolution.weight.shape == weights.shape, (convolution, weights.shape)
        with torch.no_grad():
            convolution.weight.copy_(torch.from_numpy(weights.copy()))
            convolution.bias.copy_(torch.from_numpy(bias.copy()))
    return read[len(own):]


def load_onnx(net, file):
    """Fills the network from an exported file. One made before `detail` leaves it at 0."""
    try:
        graph = onnx.load(file).graph
    except (OSError, DecodeError) as error:
        raise ValueError(f"{file}: is missing or damaged, expected an ONNX file") from error
    values = {t.name: numpy_helper.to_array(t) for t in graph.initializer}
    state = net.state_dict()
    missing = [name for name in state if name not in values and name != "detail.weight"]
    if missing:
        raise ValueError(f"{file}: has no {missing[0]}, expected a file written by export.py")
    state.update({name: torch.from_numpy(values[name].copy()) for name in state if name in values})
    net.load_state_dict(state)
