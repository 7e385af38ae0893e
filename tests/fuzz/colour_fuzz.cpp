// Colours of pictures: what files state, and foreign profiles. The first byte chooses.

#include "fuzz.hpp"
#include "image/colour.hpp"

#include <opencv2/core.hpp>

using namespace altiro3D;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    fuzz::Bytes bytes(data, size);
    const unsigned kind = bytes.byte();
    ColourFacts facts;
    if (kind % 2 == 0) {
        facts = readColourFacts(bytes.rest(), imageFormat(bytes.rest()));
    } else {
        facts.icc = bytes.rest();
    }
    cv::Mat picture(2, 3,
                    (kind & 2U) != 0   ? CV_16UC3
                    : (kind & 4U) != 0 ? CV_8UC1
                                       : CV_8UC3,
                    cv::Scalar(10, 120, 250));
    Notes notes;
    convertToSrgb(picture, facts, &notes);
    fuzz::require(picture.size() == cv::Size(3, 2), "the size stays");
    if (isCmykProfile(facts.icc)) {
        const cv::Mat inks(2, 3, CV_8UC4, cv::Scalar(10, 120, 250, 30));
        const cv::Mat colours = inksToSrgb(inks, facts.icc, (kind & 2U) != 0);
        fuzz::require(colours.empty() || colours.size() == inks.size(), "the size stays");
    }
    return 0;
}
