#include "native/view_columns.hpp"

#include "base/pixel_rows.hpp"
#include "support/processors.hpp"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>
#include <vector>

namespace altiro3D::test {
namespace {

// The sub-pixels one by one, for panels with more and with fewer columns than the photo.
TEST(ViewColumns, SubPixelsAreThoseOfTheirViewsRows) {
    cv::RNG rng(4);
    for (const int width : {1, 5, 70}) {
        const auto rowBytes = 3 * static_cast<std::size_t>(width);
        for (const std::size_t viewCount : {1, 2, 16, 17, 45, 64}) {
            std::vector<std::vector<std::uint8_t>> rows(viewCount,
                                                        paddedRow<std::uint8_t>(rowBytes));
            std::vector<std::uint8_t*> pointers;
            for (std::vector<std::uint8_t>& row : rows) {
                rng.fill(row, cv::RNG::UNIFORM, 0, 256);
                pointers.push_back(row.data());
            }
            for (const int panel : {1, 31, 64, 200}) {
                for (const bool mirrored : {false, true}) {
                    std::vector<int> columns;
                    for (int x = 0; x < panel; ++x)
                        columns.push_back((mirrored ? panel - 1 - x : x) * width / panel);
                    std::vector<std::uint8_t> views =
                        paddedRow<std::uint8_t>(static_cast<std::size_t>(panel));
                    for (std::uint8_t& view : views)
                        view =
                            static_cast<std::uint8_t>(rng.uniform(0, static_cast<int>(viewCount)));
                    forEachInstructionSet([&](const char* name) {
                        ViewColumns picker(columns);
                        picker.set(pointers, rowBytes);
                        std::vector<std::uint8_t> values = paddedRow<std::uint8_t>(columns.size());
                        for (std::size_t channel = 0; channel < 3; ++channel) {
                            picker.pick(channel, views.data(), values.data());
                            for (std::size_t i = 0; i < columns.size(); ++i)
                                ASSERT_EQ(values[i],
                                          rows[views[i]]
                                              [3 * static_cast<std::size_t>(columns[i]) + channel])
                                    << name << " " << width << " " << viewCount << " " << i;
                        }
                    });
                }
            }
        }
    }
}

} // namespace
} // namespace altiro3D::test
