// altiro3D_native_accuracy: the accuracy of Natives of a scene that is known exactly.
//
// Usage: altiro3D_native_accuracy [picture.png]
//
// The true colour of each sub-pixel of a Portrait is computed by rays into the sample scene: it
// shows the panel px, seen from the camera position that belongs to its phase under the lens.
// Prints a Markdown table for each strength: PSNR and mean absolute error over the sub-pixels of
// every 19th row, for all and for those near a depth step of the true view, and the offset of the
// Native from the truth. The picture shows one row as an eye sees it that moves from left to right:
// 48 views, continuous view positions, and the truth.

#include "altiro3D/calibration.hpp"
#include "altiro3D/depth2quilt.hpp"
#include "altiro3D/native_maker.hpp"
#include "altiro3D/quilt2native.hpp"
#include "support/files.hpp"
#include "support/scene.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <exception>
#include <functional>
#include <iostream>
#include <opencv2/core.hpp>
#include <opencv2/imgcodecs.hpp>
#include <opencv2/imgproc.hpp>
#include <stdexcept>
#include <string>
#include <vector>

namespace {

using altiro3D::ViewMethod;
using altiro3D::ViewPositions;
using altiro3D::test::RayCaster;
using altiro3D::test::Scene;

constexpr int kViews = 48;
constexpr int kRowStep = 19;     // has no factor in common with tiles, lenses or quilts
constexpr int kFirstRow = 3;     // first panel row that is compared
constexpr int kGradientStep = 4; // every fourth of them is used for the offset
constexpr int kEdgeReach = 6;    // panel px to both sides
constexpr double kEdgeStep = 0.03;

// Focal length and depth range relate the cameras' positions to parallax in px:
// focal (1/focus distance - 1/z) cameraX = -p (d - f) S/2.
struct World {
    Scene scene;
    double focus = 0;
    cv::Size panel;

    double cameraX(double strengthPercent, double position) const {
        const double range = 1 / scene.nearDistance - 1 / scene.farDistance;
        return position * strengthPercent / 200 / (scene.focalWidths * range);
    }
};

World makeWorld(cv::Size panel) {
    World world;
    world.scene = altiro3D::test::sampleScene();
    world.scene.farDistance = 1e9; // nothing is clamped
    world.focus = relativeInverseDepth(world.scene, world.scene.focusDistance);
    world.panel = panel;
    // Checks that content moves as the library's conventions say.
    for (const double z : {2.1, 4.2, 50.0}) {
        const double x = world.cameraX(20, 0.7);
        const double moved = project(world.scene, panel, x, {0.3, 1, z}).x -
                             project(world.scene, panel, 0, {0.3, 1, z}).x;
        const double d = relativeInverseDepth(world.scene, z);
        if (std::abs(moved + 0.7 * (d - world.focus) * 0.2 * panel.width / 2) > 1e-6)
            throw std::logic_error("the scene's parallax is not that of the views");
    }
    return world;
}

// Photo and exact depth.
struct Picture {
    cv::Mat photo; // [rows x cols, CV_8UC3, BGR]
    cv::Mat depth; // [rows x cols, CV_32FC1, 0..1]
};

cv::Mat castDepth(const World& world, const RayCaster& caster, cv::Size size) {
    cv::Mat depth(size, CV_32FC1);
    cv::parallel_for_(cv::Range(0, size.height), [&](const cv::Range& rows) {
        for (int y = rows.start; y < rows.end; ++y) {
            for (int x = 0; x < size.width; ++x) {
                const cv::Point2d at((x + 0.5) / size.width * world.panel.width,
                                     (y + 0.5) / size.height * world.panel.height);
                depth.at<float>(y, x) = static_cast<float>(caster.depth(world.panel, 0, at));
            }
        }
    });
    return depth;
}

cv::Mat castPhoto(const World& world, const RayCaster& caster) {
    cv::Mat photo(world.panel, CV_8UC3);
    cv::parallel_for_(cv::Range(0, photo.rows), [&](const cv::Range& rows) {
        for (int y = rows.start; y < rows.end; ++y) {
            for (int x = 0; x < photo.cols; ++x)
                photo.at<cv::Vec3b>(y, x) = caster.colour(world.panel, 0, cv::Rect(x, y, 1, 1));
        }
    });
    return photo;
}

// The position of a phase, as ViewPositions::Continuous has it.
double continuousPosition(double phase) {
    return std::clamp((2 * phase * kViews - kViews) / (kViews - 1), -1.0, 1.0);
}

double discretePosition(double phase) {
    return altiro3D::viewPosition(altiro3D::LensGeometry::viewOfPhase(phase, kViews), kViews);
}

// True pictures of the compared rows, [compared rows x panel columns, CV_8UC3, BGR].
struct Truth {
    cv::Mat native; // each sub-pixel from its own place
    cv::Mat views;  // each from the nearest of 48 places
    cv::Mat tiles;  // and averaged over the px of its tile
    cv::Mat edges;  // 255 near depth steps
    cv::Mat slopes; // CV_32FC3: change per px to the right; NaN where it is not known
};

Truth castTruth(const World& world, const RayCaster& caster, const altiro3D::LensGeometry& lens,
                cv::Size tile, double strength) {
    const int lookedAt = (world.panel.height - kFirstRow + kRowStep - 1) / kRowStep;
    const cv::Size size(world.panel.width, lookedAt);
    Truth truth;
    truth.native.create(size, CV_8UC3);
    truth.views.create(size, CV_8UC3);
    truth.tiles.create(size, CV_8UC3);
    truth.edges = cv::Mat(size, CV_8UC3, cv::Scalar::all(0));
    truth.slopes = cv::Mat(size, CV_32FC3, cv::Scalar::all(NAN));
    const cv::Size2d tilePixel(1.0 * world.panel.width / tile.width,
                               1.0 * world.panel.height / tile.height);
    cv::parallel_for_(cv::Range(0, lookedAt), [&](const cv::Range& rows) {
        for (int i = rows.start; i < rows.end; ++i) {
            const int y = kFirstRow + i * kRowStep;
            const auto tileY = std::floor((y + 0.5) / tilePixel.height);
            for (int x = 0; x < size.width; ++x) {
                const auto tileX = std::floor((x + 0.5) / tilePixel.width);
                const cv::Rect2d own(x, y, 1, 1);
                const cv::Rect2d inTile(tileX * tilePixel.width, tileY * tilePixel.height,
                                        tilePixel.width, tilePixel.height);
                for (int colour = 0; colour < 3; ++colour) {
                    const int channel = 2 - colour;
                    const double phase = lens.phase(x, y, colour);
                    const double place = world.cameraX(strength, continuousPosition(phase));
                    const double step = world.cameraX(strength, discretePosition(phase));
                    const auto cast = [&](double cameraX, const cv::Rect2d& part) {
                        return caster.colour(world.panel, cameraX, part)[channel];
                    };
                    truth.native.at<cv::Vec3b>(i, x)[channel] = cast(place, own);
                    truth.views.at<cv::Vec3b>(i, x)[channel] = cast(step, own);
                    double sum = 0; // of quarters: a px of a tile is large
                    for (const auto& [right, down] : {std::pair(0, 0), {1, 0}, {0, 1}, {1, 1}}) {
                        sum += cast(step, {inTile.x + right * inTile.width / 2,
                                           inTile.y + down * inTile.height / 2, inTile.width / 2,
                                           inTile.height / 2});
                    }
                    truth.tiles.at<cv::Vec3b>(i, x)[channel] = cv::saturate_cast<uchar>(sum / 4);
                    const cv::Point2d centre(x + 0.5, y + 0.5);
                    const double depth = caster.depth(world.panel, place, centre);
                    for (const int side : {-kEdgeReach, kEdgeReach}) {
                        const cv::Point2d beside(centre.x + side, centre.y);
                        if (std::abs(caster.depth(world.panel, place, beside) - depth) > kEdgeStep)
                            truth.edges.at<cv::Vec3b>(i, x)[channel] = 255;
                    }
                    if (i % kGradientStep != 0) continue;
                    const double right = cast(place, own + cv::Point2d(2, 0));
                    const double left = cast(place, own - cv::Point2d(2, 0));
                    truth.slopes.at<cv::Vec3f>(i, x)[channel] =
                        static_cast<float>((right - left) / 4);
                }
            }
        }
    });
    return truth;
}

cv::Mat lookedAtRows(const cv::Mat& native) {
    cv::Mat rows;
    for (int y = kFirstRow; y < native.rows; y += kRowStep)
        rows.push_back(native.row(y));
    return rows;
}

struct Error {
    double squares = 0;
    double absolute = 0;
    double count = 0;

    double psnr() const { return 10 * std::log10(255.0 * 255.0 * count / squares); }
    double mean() const { return absolute / count; }
};

// One line of the table.
void printLine(const std::string& path, const std::string& photo, const std::string& views,
               const cv::Mat& picture, const Truth& truth) {
    Error whole;
    Error edges;
    double along = 0; // of the difference on the slope, away from edges
    double slopes = 0;
    for (int y = 0; y < picture.rows; ++y) {
        const auto* have = picture.ptr<uchar>(y);
        const auto* want = truth.native.ptr<uchar>(y);
        const auto* edge = truth.edges.ptr<uchar>(y);
        const auto* slope = truth.slopes.ptr<float>(y);
        for (int i = 0; i < 3 * picture.cols; ++i) {
            const double difference = 1.0 * have[i] - want[i];
            for (Error* error : {&whole, &edges}) {
                if (error == &edges && edge[i] == 0) continue;
                error->squares += difference * difference;
                error->absolute += std::abs(difference);
                error->count += 1;
            }
            if (edge[i] != 0 || std::isnan(slope[i])) continue;
            along -= difference * static_cast<double>(slope[i]);
            slopes += static_cast<double>(slope[i] * slope[i]);
        }
    }
    std::printf("| %s | %s | %s | %.2f | %.2f | %.2f | %.2f | %+.2f |\n", path.c_str(),
                photo.c_str(), views.c_str(), whole.psnr(), whole.mean(), edges.psnr(),
                edges.mean(), along / slopes);
    std::fflush(stdout);
}

struct Paths {
    altiro3D::Calibration calibration;
    altiro3D::QuiltLayout layout;
    altiro3D::ViewOptions options; // strength and focus
    Picture inTile;
    Picture onPanel;
};

void printDirect(const Paths& paths, const Truth& truth) {
    struct Method {
        std::string name;
        ViewMethod method;
        int refinement;
    };
    const Method methods[] = {{"fast", ViewMethod::Fast, 0},
                              {"fast, refinement 2", ViewMethod::Fast, 2},
                              {"layered", ViewMethod::Layered, 0}};
    for (const Method& method : methods) {
        altiro3D::ViewOptions options = paths.options;
        options.method = method.method;
        options.refinement = method.refinement;
        for (const Picture* picture : {&paths.inTile, &paths.onPanel}) {
            for (const auto positions : {ViewPositions::Discrete, ViewPositions::Continuous}) {
                cv::Mat native;
                altiro3D::NativeRenderer(paths.calibration, kViews, options, positions)
                    .render(picture->photo, picture->depth, native);
                printLine("direct: " + method.name, picture == &paths.inTile ? "view" : "panel",
                          positions == ViewPositions::Discrete ? "48" : "continuous",
                          lookedAtRows(native), truth);
            }
        }
    }
}

void printQuilts(const Paths& paths, const Truth& truth) {
    using altiro3D::TileSampling;
    using altiro3D::ViewFilter;
    const altiro3D::QuiltSampling nearest;
    const altiro3D::QuiltSampling views{ViewFilter::Linear, TileSampling::Nearest};
    const altiro3D::QuiltSampling inTile{ViewFilter::Nearest, TileSampling::Linear};
    const altiro3D::QuiltSampling both{ViewFilter::Linear, TileSampling::Linear};
    const auto print = [&](const std::string& name, const cv::Mat& quilt, const std::string& photo,
                           const altiro3D::QuiltSampling& sampling) {
        const bool blended = sampling.views == ViewFilter::Linear;
        const bool linear = sampling.inTile == TileSampling::Linear;
        cv::Mat native;
        altiro3D::Quilt2Native(paths.calibration, paths.layout, sampling).render(quilt, native);
        printLine("quilt: " + name + (linear ? ", linear in tiles" : ""), photo,
                  blended ? "48, blended" : "48", lookedAtRows(native), truth);
    };
    for (const auto& [name, method] : {std::pair("fast", ViewMethod::Fast),
                                       {"real", ViewMethod::Real},
                                       {"layered", ViewMethod::Layered}}) {
        altiro3D::ViewOptions options = paths.options;
        options.method = method;
        const altiro3D::Depth2Quilt maker(paths.layout, options);
        cv::Mat quilt;
        maker.render(paths.inTile.photo, paths.inTile.depth, quilt);
        print(name, quilt, "view", nearest);
        if (method == ViewMethod::Layered) print(name, quilt, "view", both);
        maker.render(paths.onPanel.photo, paths.onPanel.depth, quilt);
        print(name, quilt, "panel", nearest);
        if (method != ViewMethod::Layered) continue;
        print(name, quilt, "panel", views);
        print(name, quilt, "panel", inTile);
        print(name, quilt, "panel", both);
    }
}

// One row of the panel, seen from the leftmost eye (top) to the rightmost one, for a part of the
// width and of the eye positions: in 48 views, continuous, true.
cv::Mat stepsPicture(const World& world, const RayCaster& caster, const Picture& picture) {
    constexpr int kStrength = 20;
    constexpr int kRow = 1008;
    constexpr int kScale = 2;
    constexpr int kAround = 12; // rows that may fill in what is hidden
    constexpr int kPlaces = 400;
    const cv::Range columns(1000, 1146);
    const cv::Range places(20, 220); // of 400
    const cv::Range rows(kRow - kAround, kRow + kAround + 1);
    const cv::Mat photo = picture.photo.rowRange(rows).clone();
    const cv::Mat depth = picture.depth.rowRange(rows).clone();
    altiro3D::ViewOptions options;
    options.strengthPercent = kStrength;
    options.focus = world.focus;
    const altiro3D::Depth2Quilt maker({}, options);
    cv::Mat strips[3]; // 48 views, continuous, true
    for (cv::Mat& strip : strips)
        strip.create(places.size(), columns.size(), CV_8UC3);
    cv::parallel_for_(places, [&](const cv::Range& part) {
        for (int i = part.start; i < part.end; ++i) {
            const double phase = (i + 0.5) / kPlaces;
            const double positions[] = {discretePosition(phase), continuousPosition(phase)};
            for (int k = 0; k < 2; ++k) {
                cv::Mat view;
                maker.renderView(photo, depth, positions[k], view);
                view.row(kAround).colRange(columns).copyTo(strips[k].row(i - places.start));
            }
            const double cameraX = world.cameraX(kStrength, positions[1]);
            for (int x = columns.start; x < columns.end; ++x) {
                strips[2].at<cv::Vec3b>(i - places.start, x - columns.start) =
                    caster.colour(world.panel, cameraX, cv::Rect(x, kRow, 1, 1));
            }
        }
    });
    constexpr int kGap = 6; // px
    cv::Mat all;
    for (const cv::Mat& strip : strips) {
        cv::Mat large;
        cv::resize(strip, large, {}, kScale, kScale, cv::INTER_NEAREST);
        if (all.empty()) {
            all = large;
            continue;
        }
        cv::hconcat(
            std::vector<cv::Mat>{all, cv::Mat(large.rows, kGap, CV_8UC3, {255, 255, 255}), large},
            all);
    }
    return all;
}

void run(int argc, char** argv) {
    Paths paths;
    paths.calibration =
        altiro3D::readCalibration(altiro3D::test::sourcePath("calibration/portrait-sample.json"));
    const altiro3D::LensGeometry lens = lensGeometry(paths.calibration);
    const World world = makeWorld({lens.panelWidth, lens.panelHeight});
    const RayCaster caster(world.scene);
    paths.onPanel = {castPhoto(world, caster), castDepth(world, caster, world.panel)};
    cv::resize(paths.onPanel.photo, paths.inTile.photo, paths.layout.tileSize, 0, 0,
               cv::INTER_AREA);
    paths.inTile.depth = castDepth(world, caster, paths.layout.tileSize);
    if (argc > 1) {
        cv::imwrite(argv[1], stepsPicture(world, caster, paths.onPanel),
                    {cv::IMWRITE_PNG_COMPRESSION, 9});
    }
    paths.options.focus = world.focus;
    for (const double strength : {10.0, 20.0}) {
        paths.options.strengthPercent = strength;
        const Truth truth = castTruth(world, caster, lens, paths.layout.tileSize, strength);
        std::printf("Strength %.0f %%; %.1f %% of the sub-pixels are near a depth step.\n\n"
                    "| path | photo | views | PSNR | error | at steps: PSNR | error | offset, px "
                    "|\n|---|---|---|---:|---:|---:|---:|---:|\n",
                    strength, 100 * cv::mean(truth.edges.reshape(1))[0] / 255);
        printLine("the photo, flat", "panel", "1", lookedAtRows(paths.onPanel.photo), truth);
        printDirect(paths, truth);
        printQuilts(paths, truth);
        printLine("true views", "panel", "48", truth.views, truth);
        printLine("true views in tiles", "view", "48", truth.tiles, truth);
        std::printf("\n");
    }
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
