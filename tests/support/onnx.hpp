#pragma once

#include <cstdint>
#include <cstring>
#include <opencv2/core/types.hpp>
#include <string>
#include <vector>

/// Tiny ONNX files, written field by field.
namespace altiro3D::test::onnx {

inline std::string varint(std::uint64_t value) {
    std::string bytes;
    for (; value >= 0x80; value >>= 7U)
        bytes += static_cast<char>((value & 0x7fU) | 0x80U);
    return bytes + static_cast<char>(value);
}

inline std::string number(unsigned field, std::uint64_t value) {
    return varint(field * 8U) + varint(value);
}

inline std::string bytes(unsigned field, const std::string& contents) {
    return varint(field * 8U + 2U) + varint(contents.size()) + contents;
}

inline std::string valueInfo(const std::string& name, const std::vector<int>& shape) {
    std::string dimensions;
    for (const int side : shape) // 0: open, as a named dimension
        dimensions +=
            bytes(1, side == 0 ? bytes(2, "open") : number(1, static_cast<std::uint64_t>(side)));
    const std::string tensor = number(1, 1) + bytes(2, dimensions); // 1: float
    return bytes(1, name) + bytes(2, bytes(1, tensor));
}

inline std::string tensor(const std::string& name, const std::vector<int>& shape,
                          const std::vector<float>& values) {
    std::string text;
    for (const int side : shape)
        text += number(1, static_cast<std::uint64_t>(side));
    std::string raw(values.size() * sizeof(float), '\0');
    if (!values.empty()) std::memcpy(raw.data(), values.data(), raw.size());
    return text + number(2, 1) + bytes(8, name) + bytes(9, raw);
}

inline std::string intsAttribute(const std::string& name, const std::vector<int>& values) {
    std::string text = bytes(1, name);
    for (const int value : values)
        text += number(8, static_cast<std::uint64_t>(value));
    return bytes(5, text + number(20, 7));
}

inline std::string node(const std::string& type, const std::vector<std::string>& inputs,
                        const std::vector<std::string>& outputs,
                        const std::string& attributes = "") {
    std::string text;
    for (const std::string& input : inputs)
        text += bytes(1, input);
    for (const std::string& output : outputs)
        text += bytes(2, output);
    return bytes(1, text + bytes(3, type + outputs[0]) + bytes(4, type) + attributes);
}

inline std::string model(const std::string& graph) {
    return number(1, 4) + bytes(2, "pytorch") + bytes(7, graph + bytes(2, "g")) +
           bytes(8, number(2, 9));
}

// y = sum of weights[c] * x[c], as [1, 1, H, W], or [1, H, W] where squeezed.
inline std::string mixModel(const std::vector<float>& weights, cv::Size size,
                            bool squeezed = false) {
    std::string nodes = node("Conv", {"x", "w"}, {"mixed"}, intsAttribute("kernel_shape", {1, 1}));
    std::string output = "mixed";
    std::vector<int> shape{1, 1, size.height, size.width};
    if (squeezed) {
        nodes += node("Squeeze", {"mixed"}, {"y"}, intsAttribute("axes", {1}));
        output = "y";
        shape = {1, size.height, size.width};
    }
    return model(nodes + bytes(5, tensor("w", {1, 3, 1, 1}, weights)) +
                 bytes(11, valueInfo("x", {1, 3, size.height, size.width})) +
                 bytes(12, valueInfo(output, shape)));
}

// y = one operation of x; y has x's shape.
inline std::string oneNodeModel(const std::string& type, const std::vector<int>& shape) {
    return model(node(type, {"x"}, {"y"}) + bytes(11, valueInfo("x", shape)) +
                 bytes(12, valueInfo("y", shape)));
}

} // namespace altiro3D::test::onnx
