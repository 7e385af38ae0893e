// Scenes of Gaussian splats: .ply, .spz, and by the name .splat. What is read is rendered.

#include "altiro3D/splats.hpp"
#include "fuzz.hpp"

#include <cmath>
#include <opencv2/core.hpp>

using namespace altiro3D;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    const std::string bytes(fuzz::textOf(data, size));
    for (const char* const name : {"a.ply", "a.splat"}) {
        fuzz::reads([&] {
            Notes notes;
            const SplatScene scene = parseSplats(bytes, name, SplatAxes::Auto, &notes);
            fuzz::require(!scene.splats.empty(), "a scene has splats");
            fuzz::require(scene.splats.size() / 64 <= size, "splats take bytes"); // also packed
            for (const Splat& splat : scene.splats) {
                fuzz::require(splat.opacity >= 0 && splat.opacity <= 1, "an opacity is 0..1");
                fuzz::require(std::abs(cv::norm(splat.rotation) - 1) < 1e-3, "a rotation is unit");
            }
            constexpr std::size_t kMost = 2000; // those that are quick
            if (scene.splats.size() > kMost) return;
            const auto camera = chooseSplatCamera(scene, {24, 16}, 1.5).camera;
            const SplatRenderer renderer(scene, camera);
            cv::Mat picture;
            renderer.render(0.1, 2, picture);
            (void)placeSplats(renderer.render(), camera, {2, 1, {24, 16}, 2});
        });
    }
    return 0;
}
