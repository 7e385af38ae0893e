// The facts about a network that are read before OpenCV sees it.

#include "depth/network/network_graph.hpp"
#include "fuzz.hpp"

using namespace altiro3D;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const OnnxFacts facts = readOnnxFacts(fuzz::textOf(data, size));
    std::size_t sides = 0;
    for (const GraphInput& input : facts.inputs)
        sides += input.shape.size();
    fuzz::require(sides <= size && facts.externalWeights.size() <= size,
                  "facts are no more than the bytes");
    return 0;
}
