// altiro3D_native_accuracy: what an eye sees of Natives through the lenses, beside the truth.
//
// Usage: altiro3D_native_accuracy [calibration.json] [photo or folder of photos]...
//
// Prints Markdown tables, a row for each way to make a Native: luminance PSNR in dB at a blur of 3
// px / mean CIELAB chroma difference (support/eye.hpp), means of directions over the whole cone,
// for the middle rows of the panel (of the sample Portrait unless a calibration is given).
//
// - The sample scene, with its exact depth: the truth is the view of a camera in that direction.
// - Photos at strength 0: the truth is the photo fitted to the panel.
// - Light fields of the test data: each view is the truth in its own direction. If the data is
//   missing, a line says so.
//
// The last columns are means of the row: PSNR at a blur of 2 and 4 px, and SSIM of the luminance at
// 3 px.

#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/display.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/native_maker.hpp"
#include "support/eye.hpp"
#include "support/files.hpp"
#include "support/scene.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <exception>
#include <filesystem>
#include <functional>
#include <iostream>
#include <opencv2/core.hpp>
#include <stdexcept>
#include <string>
#include <utility>
#include <vector>

namespace {

namespace fs = std::filesystem;
using namespace altiro3D;
using test::EyeDifference;
using test::EyePicture;

constexpr int kDirections = 3; // in the middle of equal parts of the cone
constexpr int kRows = 384;     // in the middle of the panel

// A way to make a Native.
struct Way {
    std::string name;
    NativeOptions options;
    bool overQuilt = false; // also where the direct path gives the same
};

template <class Set>
NativeOptions with(Set set) {
    NativeOptions options;
    set(options);
    return options;
}

std::vector<Way> ways() {
    using O = NativeOptions;
    const auto shown = [](Detail detail) { return with([=](O& o) { o.showAs(detail); }); };
    const auto quilt = [](bool isFiltered, TileSampling inTile) {
        return with([=](O& o) { o.lensFilter = isFiltered, o.sampling.inTile = inTile; });
    };
    const auto detailed = [](ViewPositions positions) {
        return with([=](O& o) { o.detail = Detail::Panel, o.positions = positions; });
    };
    return {
        {"default", shown(Detail::Lens)},
        {"default, px of the panel", shown(Detail::Panel)},
        {"--quick", {}},
        {"-k", detailed(ViewPositions::Discrete)},
        {"-k --continuous", detailed(ViewPositions::Continuous)},
        {"--method fast", with([](O& o) { o.views.method = ViewMethod::Fast; })},
        {"quilt of --quick, nearest", {}, true},
        {"quilt of --quick, linear", quilt(false, TileSampling::Linear)},
        {"quilt, linear", quilt(true, TileSampling::Linear)},
    };
}

// Something that Natives are made of, and what is true.
struct Subject {
    std::string name;
    Scene scene;                            // photo and depth
    ViewOptions views;                      // strength and focus
    std::function<cv::Mat(double)> truth{}; // by phase [panel, CV_8UC3, BGR]
};

cv::Mat nativeOf(const Display& display, const Way& way, const Subject& subject) {
    NativeOptions options = way.options;
    options.views.strengthPercent = subject.views.strengthPercent;
    options.views.focus = subject.views.focus;
    const NativeMaker maker =
        way.overQuilt
            ? NativeMaker(NativeLut(display.calibration, display.quilt, display.invert), options)
            : NativeMaker(display, options);
    cv::Mat native;
    maker.makeNative(subject.scene, native);
    return native;
}

struct Figures {
    std::array<double, 3> psnr{}; // EyePicture::kSigmas
    double chroma = 0;
    double ssim = 0;

    void add(const Figures& o, double share) {
        for (std::size_t i = 0; i < psnr.size(); ++i)
            psnr[i] += share * o.psnr[i];
        chroma += share * o.chroma;
        ssim += share * o.ssim;
    }
};

cv::Mat middle(const cv::Mat& panel) {
    const int rows = std::min(kRows, panel.rows);
    return panel.rowRange((panel.rows - rows) / 2, (panel.rows + rows) / 2);
}

Figures compare(const EyePicture& picture, const EyePicture& truth) {
    const EyeDifference difference = eyeDifference(picture, truth);
    cv::Mat grey[2];
    picture.luminance[1].convertTo(grey[0], CV_8U, 255);
    truth.luminance[1].convertTo(grey[1], CV_8U, 255);
    return {difference.luminancePsnr, difference.chroma, ssim(grey[0], grey[1])};
}

// The figures of each Native, means of the directions.
std::vector<Figures> look(const test::LensTwin& lens, const std::vector<cv::Mat>& natives,
                          const std::vector<double>& phases,
                          const std::function<cv::Mat(double)>& truthOf) {
    std::vector<Figures> figures(natives.size());
    for (const double phase : phases) {
        const EyePicture truth = test::blurredByEye(test::lightOf(middle(truthOf(phase))));
        for (std::size_t i = 0; i < natives.size(); ++i) {
            const cv::Mat seen = lens.seen(test::lightOf(natives[i]), phase);
            figures[i].add(compare(test::blurredByEye(middle(seen)), truth),
                           1.0 / static_cast<double>(phases.size()));
        }
    }
    return figures;
}

// The middles of equal parts of the cone.
std::vector<double> phasesOf(int count) {
    std::vector<double> phases;
    for (int i = 0; i < count; ++i)
        phases.push_back((i + 0.5) / count);
    return phases;
}

using Column = std::pair<std::string, std::vector<Figures>>; // its name and a figure per row

void print(const std::string& title, const std::vector<std::string>& rows,
           const std::vector<Column>& columns) {
    std::printf("%s\n\n| Native |", title.c_str());
    for (const Column& column : columns)
        std::printf(" %s |", column.first.c_str());
    std::printf(" mean | 2 px | 4 px | SSIM |\n|---|");
    for (std::size_t i = 0; i < columns.size() + 4; ++i)
        std::printf("---:|");
    for (std::size_t row = 0; row < rows.size(); ++row) {
        Figures mean;
        std::printf("\n| %s |", rows[row].c_str());
        for (const Column& column : columns) {
            const Figures& f = column.second[row];
            std::printf(" %.2f / %.2f |", f.psnr[1], f.chroma);
            mean.add(f, 1.0 / static_cast<double>(columns.size()));
        }
        std::printf(" %.2f / %.2f | %.2f | %.2f | %.4f |", mean.psnr[1], mean.chroma, mean.psnr[0],
                    mean.psnr[2], mean.ssim);
    }
    std::printf("\n\n");
    std::fflush(stdout);
}

void printSubjects(const std::string& title, const Display& display, const test::LensTwin& lens,
                   const std::vector<Subject>& subjects) {
    std::vector<std::string> rows;
    for (const Way& way : ways())
        rows.push_back(way.name);
    std::vector<Column> columns;
    for (const Subject& subject : subjects) {
        std::vector<cv::Mat> natives;
        for (const Way& way : ways())
            natives.push_back(nativeOf(display, way, subject));
        columns.emplace_back(subject.name,
                             look(lens, natives, phasesOf(kDirections), subject.truth));
    }
    print(title, rows, columns);
}

// A photo that stays where it is in all directions.
Subject photoSubject(const Display& display, const fs::path& file) {
    Subject subject{file.stem().string(), {}, {}};
    subject.views.strengthPercent = 0;
    subject.scene.photo = readPhoto(file);
    subject.scene.depth = cv::Mat(subject.scene.photo.size(), CV_32FC1, cv::Scalar(0.5));
    cv::Mat fitted;
    applyFit(subject.scene.photo,
             fitPhoto(subject.scene.photo.size(),
                      static_cast<double>(display.panelSize().width) / display.panelSize().height,
                      display.panelSize()),
             fitted);
    subject.truth = [fitted](double) { return fitted; };
    return subject;
}

// The sample scene on a panel.
struct World {
    test::Scene scene = test::sampleScene();
    cv::Size panel;
    double focus = 0;

    explicit World(cv::Size size) : panel(size) {
        scene.farDistance = 1e9; // nothing is clamped
        focus = relativeInverseDepth(scene, scene.focusDistance);
        // Checks that content moves as the library's conventions say.
        for (const double z : {2.1, 4.2, 50.0}) {
            const double moved = project(scene, panel, cameraX(20, 0.7), {0.3, 1, z}).x -
                                 project(scene, panel, 0, {0.3, 1, z}).x;
            const double d = relativeInverseDepth(scene, z);
            if (std::abs(moved + 0.7 * (d - focus) * 0.2 * panel.width / 2) > 1e-6)
                throw std::logic_error("the scene's parallax is not that of the views");
        }
    }

    // Focal length and depth range relate the cameras' positions to parallax in px:
    // focal (1/focus distance - 1/z) cameraX = -p (d - f) S/2.
    double cameraX(double strengthPercent, double position) const {
        const double range = 1 / scene.nearDistance - 1 / scene.farDistance;
        return position * strengthPercent / 200 / (scene.focalWidths * range);
    }

    // Calls set(x, y) for all px of some rows.
    template <class Set>
    void forPixels(const cv::Range& rows, const Set& set) const {
        cv::parallel_for_(rows, [&](const cv::Range& part) {
            for (int y = part.start; y < part.end; ++y) {
                for (int x = 0; x < panel.width; ++x)
                    set(x, y);
            }
        });
    }
};

std::vector<Subject> sceneSubjects(const Display& display, const World& world,
                                   const test::RayCaster& caster) {
    const auto photo = [&](double cameraX, const cv::Range& rows) {
        cv::Mat picture(world.panel, CV_8UC3, cv::Scalar::all(0));
        world.forPixels(rows, [&](int x, int y) {
            picture.at<cv::Vec3b>(y, x) = caster.colour(world.panel, cameraX, cv::Rect(x, y, 1, 1));
        });
        return picture;
    };
    Subject subject;
    subject.views.focus = world.focus;
    subject.scene.photo = photo(0, {0, world.panel.height});
    subject.scene.depth.create(world.panel, CV_32FC1);
    world.forPixels({0, world.panel.height}, [&](int x, int y) {
        subject.scene.depth.at<float>(y, x) =
            static_cast<float>(caster.depth(world.panel, 0, {x + 0.5, y + 0.5}));
    });
    std::vector<Subject> subjects;
    for (const double strength : {10.0, 20.0}) {
        subject.name = "strength " + std::to_string(static_cast<int>(strength)) + " %";
        subject.views.strengthPercent = strength;
        subject.truth = [&display, &world, ahead = subject.scene.photo, strength,
                         photo](double phase) {
            const int count = display.quilt.viewCount; // as ViewPositions::Continuous has it
            const double position =
                std::clamp((2 * phase * count - count) / (count - 1), -1.0, 1.0);
            if (position == 0) return ahead;
            const int rows = std::min(kRows, world.panel.height);
            return photo(world.cameraX(strength, position),
                         {(world.panel.height - rows) / 2, (world.panel.height + rows) / 2});
        };
        subjects.push_back(subject);
    }
    return subjects;
}

// Views of a row of cameras that are made into a quilt of the display's tiles.
void printLightFields(const Display& display, const test::LensTwin& lens) {
    struct Field {
        std::string folder;
        std::string names; // begin of the names of the views
        int columns;
        int rows;
    };
    const Field fields[] = {{"greenbuddha_33", "GreenBuddha", 11, 3},
                            {"stanford_cards", "r08_", 3, 3}};
    const std::pair<std::string, QuiltSampling> samplings[] = {
        {"nearest", {}},
        {"linear in views", {ViewFilter::Nearest, TileSampling::Linear}},
        {"linear in and between views", {ViewFilter::Linear, TileSampling::Linear}}};
    std::vector<std::string> rows;
    for (const auto& sampling : samplings)
        rows.push_back(sampling.first);
    std::vector<Column> columns;
    for (const Field& field : fields) {
        const fs::path folder = test::dataPath("lightfields/" + field.folder);
        if (folder.empty()) {
            std::printf("Light field %s: left out, it is not in the test data.\n\n",
                        field.folder.c_str());
            continue;
        }
        QuiltLayout layout{field.columns, field.rows, display.quilt.tileSize,
                           field.columns * field.rows};
        cv::Mat quilt(layout.size(), CV_8UC3);
        std::vector<cv::Mat> views;
        for (const fs::path& file : listImages(folder)) {
            if (file.filename().string().rfind(field.names, 0) != 0) continue;
            views.push_back(readPhoto(file));
            const auto fitted = [&](cv::Size size) {
                cv::Mat result;
                applyFit(views.back(),
                         fitPhoto(views.back().size(),
                                  static_cast<double>(display.panelSize().width) /
                                      display.panelSize().height,
                                  size),
                         result);
                return result;
            };
            fitted(layout.tileSize).copyTo(quilt(layout.tile(static_cast<int>(views.size()) - 1)));
            views.back() = fitted(display.panelSize());
        }
        if (static_cast<int>(views.size()) != layout.viewCount)
            throw std::runtime_error(folder.string() + ": has " + std::to_string(views.size()) +
                                     " views, expected " + std::to_string(layout.viewCount));
        std::vector<cv::Mat> natives;
        for (const auto& sampling : samplings) {
            Quilt2Native(display.calibration, layout, sampling.second, display.invert)
                .render(quilt, natives.emplace_back());
        }
        std::vector<double> phases; // the middles of views
        for (const double phase : phasesOf(kDirections)) {
            phases.push_back((LensGeometry::viewOfPhase(phase, layout.viewCount) + 0.5) /
                             layout.viewCount);
        }
        columns.emplace_back(field.folder, look(lens, natives, phases, [&](double phase) {
                                 return views[static_cast<std::size_t>(
                                     LensGeometry::viewOfPhase(phase, layout.viewCount))];
                             }));
    }
    if (!columns.empty()) print("Light fields, quilts of their views:", rows, columns);
}

void run(int argc, char** argv) {
    fs::path calibration = test::sourcePath("calibration/portrait-sample.json");
    std::vector<fs::path> photos;
    for (int i = 1; i < argc; ++i) {
        const fs::path name = argv[i];
        if (name.extension() == ".json") {
            calibration = name;
        } else if (fs::is_directory(name)) {
            for (const fs::path& file : listImages(name))
                photos.push_back(file);
        } else {
            photos.push_back(name);
        }
    }
    const Display display = readDisplay(calibration);
    const test::LensTwin lens(lensGeometry(display.calibration, display.invert));
    const cv::Mat grey(display.panelSize(), CV_8UC3, cv::Scalar::all(128));
    const Figures mosaic =
        look(lens, {grey}, phasesOf(kDirections), [&](double) { return grey.clone(); }).front();
    std::printf("%d directions, %d rows. Plain grey, which is the mosaic alone: %.2f / %.2f.\n\n",
                kDirections, std::min(kRows, grey.rows), mosaic.psnr[1], mosaic.chroma);
    std::vector<Subject> subjects;
    for (const fs::path& photo : photos)
        subjects.push_back(photoSubject(display, photo));
    if (!subjects.empty()) printSubjects("Photos at strength 0:", display, lens, subjects);
    printLightFields(display, lens);
    const World world(display.panelSize());
    const test::RayCaster caster(world.scene);
    printSubjects("The sample scene:", display, lens, sceneSubjects(display, world, caster));
}

} // namespace

int main(int argc, char** argv) {
    try {
        run(argc, argv);
        return 0;
    } catch (const std::exception& error) {
        std::cerr << "altiro3D_native_accuracy: error: " << error.what() << "\n";
        return 1;
    }
}
