#include "altiro3D/altiro3D.hpp"

#include "support/displays.hpp"
#include "support/memory_limit.hpp"
#include "support/random_pictures.hpp"

#include <functional>
#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace altiro3D::test {
namespace {

// What a caller sees of a call that needs more memory than there is.
std::string outcomeOf(const std::function<void()>& call) {
    const MemoryLimit limit(4);
    try {
        call();
    } catch (const Error& error) {
        return errorCodeName(error.code());
    } catch (const std::bad_alloc&) {
        return "bad_alloc";
    } catch (const cv::Exception& exception) {
        return "cv::Exception: " + exception.err;
    }
    return "nothing";
}

TEST(Border, ShortMemoryIsNotReportedByOpenCvsException) {
    ALTIRO3D_REQUIRE_MEMORY_LIMITS();
    const cv::Size size(3000, 2500);
    const cv::Mat photo = randomPhoto(size);
    const cv::Mat depth = randomDepth(size);
    const altiro3D::Scene scene{photo, depth};
    const QuiltLayout layout{2, 2, {1500, 1250}, 4};
    const Calibration calibration = stripePanel(size.width, size.height);
    const PhotoFit fit = fitPhoto(size, 1, {2400, 2400});
    const int threads = cv::getNumThreads();
    cv::setNumThreads(1); // no thread of the pool begins in the limit
    cv::Mat result;
    cv::Mat other;
    const std::pair<const char*, std::function<void()>> calls[] = {
        {"normalizeDepth", [&] { normalizeDepth(depth, result); }},
        {"fitDepth",
         [&] {
             fitDepth(depth, {0, 0, 3000, 2500}, photo, result);
         }},
        {"refineDepth", [&] { refineDepth(photo, depth, result); }},
        {"bendDepth", [&] { result = bendDepth(depth, 1.5); }},
        {"depthTo16Bit", [&] { result = depthTo16Bit(depth); }},
        {"splitRgbd", [&] { splitRgbd(photo, {}, result, other); }},
        {"joinRgbd", [&] { joinRgbd(photo, depth, {}, result); }},
        {"applyFit", [&] { applyFit(photo, fit, result); }},
        {"applyFitToDepth", [&] { applyFitToDepth(depth, size, fit, {}, 0.5, result); }},
        {"placeScene",
         [&] {
             placeScene(scene, 1, {2400, 2400}, {});
         }},
        {"renderView", [&] { Depth2Quilt(layout).renderView(scene, 1, result); }},
        {"render", [&] { Depth2Quilt(layout).render(scene, result); }},
        {"renderEyes", [&] { renderEyes(scene, {}); }},
        {"joinEyes", [&] { joinEyes(photo, photo, EyesPicture::SideBySide, result); }},
        {"simulateView",
         [&] {
             simulateView(photo, calibration, {0.5, 0, 2}, result);
         }},
        {"encodePicture", [&] { encodePicture(photo); }},
        {"photoViews", [&] { photoViews(scene)(1, result); }},
        {"ssim", [&] { ssim(photo, photo); }},
    };
    for (const auto& [name, call] : calls) {
        result.release();
        other.release();
        const std::string outcome = outcomeOf(call);
        EXPECT_TRUE(outcome == "bad_alloc" || outcome == "OutOfMemory") << name << ": " << outcome;
    }
    cv::setNumThreads(threads);
}

} // namespace
} // namespace altiro3D::test
