#include "depth/network/network_graph.hpp"

#include <algorithm>
#include <optional>

namespace altiro3D {

namespace {

enum class WireType { Varint = 0, Fixed64 = 1, Bytes = 2, Fixed32 = 5 };

// One field of a protobuf message. Parsers skip a known field of another wire type.
struct Field {
    std::uint32_t number = 0;
    WireType type = WireType::Varint;
    std::uint64_t value = 0; // if it is a Varint
    std::string_view bytes;  // if it is another type

    bool isNumber(std::uint32_t wanted) const {
        return number == wanted && type == WireType::Varint;
    }
    bool isBytes(std::uint32_t wanted) const { return number == wanted && type == WireType::Bytes; }
};

// Steps through the fields of one message; never reads outside of it.
class FieldWalk {
  public:
    explicit FieldWalk(std::string_view message) : rest_(message) {}

    // The next field; nothing at the end and at the first invalid field (see broken).
    std::optional<Field> next() {
        if (rest_.empty() || broken_) return std::nullopt;
        Field field;
        const auto tag = static_cast<std::uint32_t>(varint()); // parsers drop higher bits
        field.number = tag >> 3U;
        field.type = static_cast<WireType>(tag & 7U);
        if (field.type == WireType::Varint) {
            field.value = varint();
        } else if (field.type == WireType::Bytes) {
            field.bytes = take(varint());
        } else if (field.type == WireType::Fixed64 || field.type == WireType::Fixed32) {
            field.bytes = take(field.type == WireType::Fixed64 ? 8 : 4);
        } else { // groups, which ONNX does not use
            broken_ = true;
        }
        if (field.number == 0) broken_ = true;
        if (broken_) return std::nullopt;
        return field;
    }

    bool broken() const { return broken_; }

  private:
    std::uint64_t varint() {
        std::uint64_t value = 0;
        for (unsigned shift = 0; shift < 64 && !rest_.empty(); shift += 7) {
            const auto byte = static_cast<unsigned char>(rest_.front());
            rest_.remove_prefix(1);
            value |= static_cast<std::uint64_t>(byte & 0x7fU) << shift;
            if (byte < 0x80U) return value;
        }
        broken_ = true;
        return 0;
    }

    std::string_view take(std::uint64_t count) {
        if (count > rest_.size()) {
            broken_ = true;
            return {};
        }
        const std::string_view taken = rest_.substr(0, static_cast<std::size_t>(count));
        rest_.remove_prefix(taken.size());
        return taken;
    }

    std::string_view rest_;
    bool broken_ = false;
};

template <typename Visit>
void forEachField(std::string_view message, bool& broken, Visit visit) {
    FieldWalk walk(message);
    while (const auto field = walk.next())
        visit(*field);
    broken = broken || walk.broken();
}

// TensorProto. Returns the tensor's name.
std::string readTensor(std::string_view message, OnnxFacts& facts) {
    std::string name;
    std::string location;
    bool external = false;
    forEachField(message, facts.broken, [&](const Field& field) {
        if (field.isBytes(8)) name = field.bytes;
        if (field.isNumber(14)) // parsers keep the lower 32 bits of an enumeration
            external = static_cast<std::uint32_t>(field.value) == 1;
        if (!field.isBytes(13)) return; // external_data: a list of key and value
        std::string_view key;
        std::string_view value;
        forEachField(field.bytes, facts.broken, [&](const Field& entry) {
            if (entry.isBytes(1)) key = entry.bytes;
            if (entry.isBytes(2)) value = entry.bytes;
        });
        if (key == "location") location = value;
    });
    if (external) facts.externalWeights.insert(location);
    return name;
}

// ValueInfoProto -> TypeProto -> Tensor -> TensorShapeProto -> Dimension.
GraphInput readGraphInput(std::string_view message, bool& broken) {
    GraphInput input;
    const auto readShape = [&](const Field& shape) {
        if (!shape.isBytes(1)) return;
        input.shape.push_back(0);
        forEachField(shape.bytes, broken, [&](const Field& dimension) {
            if (dimension.isNumber(1))
                input.shape.back() = static_cast<std::int64_t>(dimension.value);
        });
    };
    forEachField(message, broken, [&](const Field& info) {
        if (info.isBytes(1)) input.name = info.bytes;
        if (!info.isBytes(2)) return;
        forEachField(info.bytes, broken, [&](const Field& type) {
            if (!type.isBytes(1)) return;
            forEachField(type.bytes, broken, [&](const Field& tensor) {
                if (!tensor.isBytes(2)) return;
                input.hasShape = true;
                forEachField(tensor.bytes, broken, readShape);
            });
        });
    });
    return input;
}

constexpr int kMaxDepth = 16; // nested graphs

void readGraph(std::string_view message, int depth, OnnxFacts& facts,
               std::set<std::string>& weights);

// SparseTensorProto: its values and indices are tensors.
std::string readSparseTensor(std::string_view message, OnnxFacts& facts) {
    std::string name;
    forEachField(message, facts.broken, [&](const Field& field) {
        if (field.isBytes(1)) name = readTensor(field.bytes, facts);
        if (field.isBytes(2)) readTensor(field.bytes, facts);
    });
    return name;
}

// AttributeProto: may hold tensors, and the graphs of conditions and loops.
void readAttribute(std::string_view message, int depth, OnnxFacts& facts) {
    std::set<std::string> inner;
    forEachField(message, facts.broken, [&](const Field& attribute) {
        const auto isOneOf = [&](std::uint32_t one, std::uint32_t list) {
            return attribute.isBytes(one) || attribute.isBytes(list);
        };
        if (isOneOf(5, 10)) readTensor(attribute.bytes, facts);
        if (isOneOf(6, 11)) readGraph(attribute.bytes, depth + 1, facts, inner);
        if (isOneOf(22, 23)) readSparseTensor(attribute.bytes, facts);
    });
}

// NodeProto.
void readNode(std::string_view message, int depth, OnnxFacts& facts) {
    forEachField(message, facts.broken, [&](const Field& node) {
        if (node.isBytes(5)) readAttribute(node.bytes, depth, facts);
    });
}

// GraphProto, without its inputs.
void readGraph(std::string_view message, int depth, OnnxFacts& facts,
               std::set<std::string>& weights) {
    if (depth > kMaxDepth) {
        facts.broken = true;
        return;
    }
    forEachField(message, facts.broken, [&](const Field& graph) {
        if (graph.isBytes(1)) readNode(graph.bytes, depth, facts);
        if (graph.isBytes(5)) weights.insert(readTensor(graph.bytes, facts));
        if (graph.isBytes(15)) weights.insert(readSparseTensor(graph.bytes, facts));
    });
}

} // namespace

OnnxFacts readOnnxFacts(std::string_view model) {
    OnnxFacts facts;
    std::set<std::string> weights;
    forEachField(model, facts.broken, [&](const Field& field) {
        if (field.isBytes(25)) { // FunctionProto: its nodes, and defaults of its attributes
            forEachField(field.bytes, facts.broken, [&](const Field& function) {
                if (function.isBytes(7)) readNode(function.bytes, 0, facts);
                if (function.isBytes(11)) readAttribute(function.bytes, 0, facts);
            });
        }
        if (!field.isBytes(7) || field.bytes.empty()) return;
        facts.hasGraph = true;
        readGraph(field.bytes, 0, facts, weights);
        forEachField(field.bytes, facts.broken, [&](const Field& graph) {
            if (graph.isBytes(11))
                facts.inputs.push_back(readGraphInput(graph.bytes, facts.broken));
        });
    });
    // Older exporters list every weight also as an input.
    facts.inputs.erase(
        std::remove_if(facts.inputs.begin(), facts.inputs.end(),
                       [&](const GraphInput& input) { return weights.count(input.name) > 0; }),
        facts.inputs.end());
    return facts;
}

} // namespace altiro3D
