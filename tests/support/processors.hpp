#pragma once

#include "support/compare.hpp"

#include <cstdint>
#include <hwy/highway.h>
#include <initializer_list>
#include <opencv2/core/utility.hpp>

namespace altiro3D::test {

/// Restores OpenCV's number of threads at the end of the scope, however a test ends. The test may
/// call cv::setNumThreads() in between.
class RestoredThreads {
  public:
    RestoredThreads() = default;
    ~RestoredThreads() { cv::setNumThreads(before_); }
    RestoredThreads(const RestoredThreads&) = delete;
    RestoredThreads& operator=(const RestoredThreads&) = delete;

  private:
    int before_ = cv::getNumThreads();
};

/// Expects the picture that make() returns to be the same for any number of threads.
template <class Make>
void expectSameForAnyThreads(const Make& make, std::initializer_list<int> counts = {2, 3, 7}) {
    const RestoredThreads restored;
    cv::setNumThreads(1);
    const cv::Mat one = make();
    for (const int count : counts) {
        cv::setNumThreads(count);
        EXPECT_TRUE(samePicture(make(), one)) << count << " threads";
    }
}

/// Calls use(name) while kernels run on each of the instruction sets of this machine and on EMU128,
/// one after the other.
template <class Use>
void forEachInstructionSet(const Use& use) {
    struct Restored {
        static void choose(std::int64_t target) {
            hwy::SetSupportedTargetsForTest(target);
            hwy::GetChosenTarget().DeInit();
        }
        ~Restored() { choose(0); }
    };
    const Restored restored;
    // any machine supports it, even if Highway was built without it
    Restored::choose(hwy::SupportedTargets() | HWY_EMU128);
    for (const std::int64_t target : hwy::SupportedAndGeneratedTargets()) {
        Restored::choose(target);
        use(hwy::TargetName(target));
    }
}

} // namespace altiro3D::test
