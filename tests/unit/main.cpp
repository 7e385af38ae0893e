#include "altiro3D/depth_network.hpp"

#include <gtest/gtest.h>

int main(int argc, char** argv) {
    if (altiro3D::answerProbe({argv + 1, argv + argc})) return 0; // it was started to try a network
    ::testing::InitGoogleTest(&argc, argv);
    return RUN_ALL_TESTS();
}
