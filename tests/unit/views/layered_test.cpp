#include "views/view_methods.hpp"

#include "altiro3D/depth2quilt.hpp"
#include "base/pixel_rows.hpp"
#include "support/compare.hpp"
#include "support/files.hpp"
#include "support/middlebury.hpp"
#include "support/pixels.hpp"
#include "support/random_pictures.hpp"
#include "views/layered/layered_ends.hpp"
#include "views/layered/layered_scene.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <limits>
#include <numeric>
#include <opencv2/imgproc.hpp>

namespace altiro3D::test {
namespace {

// Blobs with steps between them, and slopes.
cv::Mat blobDepth(cv::Size size, int seed = 2) {
    cv::RNG rng(static_cast<std::uint64_t>(seed));
    cv::Mat depth = pictureOf<float>(
        size, [&](int x, int) { return 0.1F + 0.2F * static_cast<float>(x) / 100; });
    for (int i = 0; i < 12; ++i) {
        const cv::Point centre(rng.uniform(0, size.width), rng.uniform(0, size.height));
        const cv::Size half(rng.uniform(2, 16), rng.uniform(2, 12));
        cv::ellipse(depth, centre, half, 0, 0, 360, cv::Scalar(rng.uniform(0.2, 1.0)), -1);
    }
    return depth;
}

cv::Mat rendered(const cv::Mat& photo, const cv::Mat& depth, double focus, double shift,
                 const LayeredSettings& options = {}) {
    cv::Mat view(photo.size(), CV_8UC3, cv::Scalar(1, 2, 3));
    makeLayeredRenderer(photo, depth, focus, options)->render(shift, view);
    return view;
}

cv::Mat mirrored(const cv::Mat& picture) {
    cv::Mat result;
    cv::flip(picture, result, 1);
    return result;
}

// As an 8-bit picture would hold it.
cv::Mat quantised(const cv::Mat& depth) {
    cv::Mat bytes;
    cv::Mat result;
    depth.convertTo(bytes, CV_8U, 255);
    bytes.convertTo(result, CV_32F, 1 / 255.0);
    return result;
}

const cv::Size kSizes[] = {{1, 1},   {2, 1},   {1, 2},  {2, 3}, {61, 37},
                           {64, 48}, {128, 5}, {1, 40}, {40, 1}};

// A red board, columns 20..39, before a wall that is blue at its left and green at its right.
struct Board {
    cv::Mat photo = cv::Mat(9, 64, CV_8UC3);
    cv::Mat depth = cv::Mat(9, 64, CV_32FC1);
    const cv::Vec3b blue{200, 40, 20};
    const cv::Vec3b green{30, 180, 60};
    const cv::Vec3b red{20, 10, 220};

    Board(float wall, float board) {
        forPixels(photo.size(), [&](int x, int y) {
            const bool isBoard = x >= 20 && x < 40;
            photo.at<cv::Vec3b>(y, x) = isBoard ? red : x < 20 ? blue : green;
            depth.at<float>(y, x) = isBoard ? board : wall;
        });
    }
};

cv::Vec3b mean(const cv::Vec3b& a, const cv::Vec3b& b) {
    cv::Vec3b result;
    for (int c = 0; c < 3; ++c)
        result[c] = static_cast<uchar>((a[c] + b[c] + 1) / 2);
    return result;
}

TEST(ViewsLayered, KnownBackgroundIsShownWhereThePhotoHidesIt) {
    const Board board(0.25F, 0.75F);
    const cv::Vec3b violet(150, 20, 140);
    LayeredSettings options;
    options.reachPixels = 16;
    const cv::Mat painted = rendered(board.photo, board.depth, 0.5, 12, options);
    options.hidden = {cv::Mat(board.photo.size(), CV_8UC3, violet),
                      cv::Mat(board.photo.size(), CV_32FC1, cv::Scalar(0.25))};
    const cv::Mat view = rendered(board.photo, board.depth, 0.5, 12, options);
    // the board, columns 20..39, moves by 3 px to the left, the wall by 3 px to the right
    for (int y = 0; y < view.rows; ++y) {
        for (int x = 39; x <= 41; ++x) { // columns 38 and 42 may be mixed
            EXPECT_EQ(view.at<cv::Vec3b>(y, x), violet) << x;
            EXPECT_EQ(painted.at<cv::Vec3b>(y, x), board.green) << x;
        }
        EXPECT_EQ(view.at<cv::Vec3b>(y, 30), board.red);
        EXPECT_EQ(view.at<cv::Vec3b>(y, 50), board.green);
    }
    EXPECT_TRUE(samePicture(
        rendered(mirrored(board.photo), mirrored(board.depth), 0.5, -12, options), mirrored(view)));
    // what lies at another depth, or nowhere, is not used
    options.hidden.depth.setTo(0.75);
    EXPECT_TRUE(samePicture(rendered(board.photo, board.depth, 0.5, 12, options), painted));
    options.hidden.depth.setTo(std::numeric_limits<float>::quiet_NaN());
    EXPECT_TRUE(samePicture(rendered(board.photo, board.depth, 0.5, 12, options), painted));
}

std::vector<int> numbersFrom(int first, int count) {
    std::vector<int> numbers(static_cast<std::size_t>(count));
    std::iota(numbers.begin(), numbers.end(), first);
    return numbers;
}

// Settings for photos with mixed px of this width.
LayeredSettings settingsFor(int mixedPixels) {
    LayeredSettings settings;
    settings.mixedPixels = mixedPixels;
    return settings;
}

// In rows whose other sub-pixels move; view_methods_test.cpp has whole views.
TEST(ViewsLayered, SubPixelsWithoutAShiftAreThoseOfThePhoto) {
    for (const int mixed : {0, 2}) {
        for (const cv::Size size : kSizes) {
            const cv::Mat photo = randomPhoto(size);
            const auto renderer =
                makeLayeredRenderer(photo, blobDepth(size), 0.4, settingsFor(mixed));
            const std::vector<int> columns = numbersFrom(0, size.width);
            const auto sampler = renderer->sampler(columns, {}, 32);
            const std::vector<float> shifts(columns.size() + kRowPadding);
            std::vector<std::uint8_t> values(columns.size() + kRowPadding);
            for (int y = 0; y < size.height; ++y) {
                sampler->open(y);
                if (sampler->still()) continue;
                sampler->sample(y % 3, shifts.data(), values.data());
                for (int x = 0; x < size.width; ++x)
                    ASSERT_EQ(values[static_cast<std::size_t>(x)], photo.at<cv::Vec3b>(y, x)[y % 3])
                        << size << x;
            }
        }
    }
}

// Shift 10: the board moves by 10 (0.75 - 0.25) = 5 px, the wall at the focus stays.
TEST(ViewsLayered, BoardBeforeAWallHidesAndReveals) {
    const Board board(0.25F, 0.75F);
    for (const int dilation : {0, 1, 2}) {
        LayeredSettings options;
        options.edgeDilationPixels = dilation;
        for (const int direction : {1, -1}) {
            const cv::Mat view = rendered(board.photo, board.depth, 0.25, 10 * direction, options);
            for (int x = 0; x < 64; ++x) {
                const int first = 20 - 5 * direction;
                cv::Vec3b expected = x < 20 ? board.blue : board.green;
                if (direction < 0 && x >= 20 && x < first) expected = board.blue; // revealed
                if (x >= first && x < first + 20) expected = board.red;
                EXPECT_EQ(view.at<cv::Vec3b>(4, x), expected) << x << " " << direction;
            }
        }
    }
}

TEST(ViewsLayered, BordersOfThingsAreExactToAPartOfAPixel) {
    const Board board(0.25F, 0.75F);
    const cv::Mat view = rendered(board.photo, board.depth, 0.25, 5); // by 2.5 px: 17.5 .. 37.5
    for (const auto& [x, colour] : {std::pair(16, board.blue),
                                    {17, mean(board.blue, board.red)},
                                    {18, board.red},
                                    {36, board.red},
                                    {37, mean(board.green, board.red)},
                                    {38, board.green}})
        EXPECT_EQ(view.at<cv::Vec3b>(4, x), colour) << x;
}

// The photo's border pixels are mixed: in the view they must not lie around as a line.
TEST(ViewsLayered, MixedBorderPixelsStayWithTheBorder) {
    Board board(0.25F, 0.75F);
    board.photo.col(19).setTo(cv::Scalar(mean(board.blue, board.red)));
    board.photo.col(40).setTo(cv::Scalar(mean(board.green, board.red)));
    const cv::Mat view = rendered(board.photo, board.depth, 0.25, 10); // 14.5 .. 35.5
    EXPECT_EQ(view.at<cv::Vec3b>(4, 13), board.blue);
    EXPECT_LE(cv::norm(view.at<cv::Vec3b>(4, 14), mean(board.blue, board.red), cv::NORM_INF), 1);
    EXPECT_EQ(view.at<cv::Vec3b>(4, 15), board.red);
    EXPECT_EQ(view.at<cv::Vec3b>(4, 34), board.red);
    EXPECT_LE(cv::norm(view.at<cv::Vec3b>(4, 35), mean(board.green, board.red), cv::NORM_INF), 1);
    for (int x = 36; x < 64; ++x)
        EXPECT_EQ(view.at<cv::Vec3b>(4, x), board.green) << x;
}

// A plain board before a wall with a pattern, behind a Gaussian blur. The wall is at the focus.
struct SoftBoard {
    cv::Mat photo = cv::Mat(15, 90, CV_8UC3);
    cv::Mat depth = cv::Mat(15, 90, CV_32FC1);
    double sigma;

    // @param grown px by which refinement has extended the board
    SoftBoard(double blur, int grown) : sigma(blur) {
        forPixels(photo.size(), [&](int x, int y) {
            photo.at<cv::Vec3b>(y, x) = colour(x, 0);
            depth.at<float>(y, x) = x >= 40 - grown && x < 60 + grown ? 1.0F : 0.0F;
        });
    }

    // What a view shows whose board has moved to the left by `shift` px.
    cv::Vec3b colour(int x, double shift) const {
        const auto below = [&](double edge) { // the part of a Gaussian left of an edge
            return std::erf((edge - shift - x) / (sigma * std::sqrt(2.0))) / 2;
        };
        const double board = below(59.5) - below(39.5);
        cv::Vec3b result;
        for (int c = 0; c < 3; ++c) {
            const double wall = 120 + 80 * std::sin(0.15 * x + c);
            const double plain = c == 2 ? 200 : 30;
            result[c] = cv::saturate_cast<uchar>(board * plain + (1 - board) * wall);
        }
        return result;
    }

    // Mean squared error at the border that moves over the wall, or at the other one.
    double errorOf(const cv::Mat& view, int shift, bool trailing = false) const {
        double sum = 0;
        const int begin = trailing ? 54 : 33;
        for (int x = begin - shift; x < begin + 13 - shift; ++x) {
            const cv::Vec3d error =
                cv::Vec3d(view.at<cv::Vec3b>(7, x)) - cv::Vec3d(colour(x, shift));
            sum += error.dot(error) / (3 * 13);
        }
        return sum;
    }
};

TEST(ViewsLayered, ColoursOfSoftBordersAreSplit) {
    const std::pair<int, double> blurs[] = {{0, 0.7}, {1, 1.7}, {2, 2.7}}; // mixed px, sigma
    for (const auto& [mixed, sigma] : blurs) {
        const SoftBoard board(sigma, mixed);
        for (const int shift : {3, 7, 11}) {
            LayeredSettings settings = settingsFor(mixed);
            const cv::Mat soft = rendered(board.photo, board.depth, 0, shift, settings);
            settings.softBorders = false;
            const cv::Mat hard = rendered(board.photo, board.depth, 0, shift, settings);
            const double error = board.errorOf(hard, shift);
            EXPECT_GT(error, 30) << sigma << " " << shift;
            // where the wall is behind the board it is not known, so small movements gain less
            EXPECT_LT(board.errorOf(soft, shift), (shift > 3 ? 0.25 : 0.75) * error)
                << sigma << " " << shift;
            // the other border, if the wall behind it is known
            cv::Mat wall(board.photo.size(), CV_8UC3);
            for (int x = 0; x < wall.cols; ++x)
                wall.col(x).setTo(cv::Scalar(board.colour(x, 1000)));
            settings.hidden = {wall, cv::Mat(wall.size(), CV_32FC1, cv::Scalar(0))};
            const cv::Mat hardEnd = rendered(board.photo, board.depth, 0, shift, settings);
            settings.softBorders = true;
            const cv::Mat softEnd = rendered(board.photo, board.depth, 0, shift, settings);
            EXPECT_LT(board.errorOf(softEnd, shift, true),
                      (shift > 3 ? 0.25 : 0.75) * board.errorOf(hardEnd, shift, true))
                << sigma << " " << shift;
        }
    }
}

// Hard edges, as of drawings, before a wall with a pattern.
TEST(ViewsLayered, BordersThatThePhotoShowsClearlyAreHard) {
    Board board(0.25F, 0.75F);
    for (int x = 0; x < 64; ++x)
        if (x < 20 || x >= 40)
            board.photo.col(x).setTo(cv::Scalar(200 - 3 * x % 40, 180, 2 * x % 50));
    LayeredSettings hard;
    hard.softBorders = false;
    for (const double shift : {-11.0, 2.5, 16.0})
        EXPECT_TRUE(samePicture(rendered(board.photo, board.depth, 0.25, shift),
                                rendered(board.photo, board.depth, 0.25, shift, hard)));
}

TEST(ViewsLayered, SoftDepthStepsOfNetworksAreMadeSharp) {
    Board board(0.25F, 0.75F);
    for (const int x : {19, 40}) { // three px of slope on each side
        const int out = x == 19 ? -1 : 1;
        for (int k = 0; k < 3; ++k)
            board.depth.col(x + out * (k - 1)).setTo(0.625F - 0.125F * static_cast<float>(k));
    }
    const cv::Mat view = rendered(board.photo, board.depth, 0.25, 10);
    for (int x = 0; x < 64; ++x) {
        const cv::Vec3b expected = x < 15 ? board.blue : x < 35 ? board.red : board.green;
        EXPECT_EQ(view.at<cv::Vec3b>(4, x), expected) << x;
    }
}

TEST(ViewsLayered, HiddenThingsLookTheSameInAllViews) {
    cv::Mat photo = randomPhoto({64, 9});
    const Board board(0.25F, 0.75F);
    board.photo.colRange(18, 42).copyTo(photo.colRange(18, 42));
    const auto renderer = makeLayeredRenderer(photo, board.depth, 0, {});
    cv::Mat first(photo.size(), CV_8UC3);
    cv::Mat second(photo.size(), CV_8UC3);
    renderer->render(16, first);  // the board moves by 12, the wall by 4
    renderer->render(24, second); // by 18 and 6
    // behind the board 40 - 8 .. 39 came to light in both
    EXPECT_TRUE(samePicture(second.colRange(33 - 6, 58 - 6), first.colRange(33 - 4, 58 - 4)));
}

// A bar of 4 px before a board, at its right border, before a wall. Both move with the camera: the
// bar by 10 px, the wall by 10 px to the other side. The bar has passed what it hid of the board.
TEST(ViewsLayered, ThinThingsPassWhatTheyHide) {
    const cv::Vec3b board(20, 10, 220);
    const cv::Vec3b bar(200, 40, 20);
    const cv::Vec3b wall(30, 180, 60);
    const cv::Size size(96, 5);
    cv::Mat photo(size, CV_8UC3, cv::Scalar(board));
    cv::Mat depth(size, CV_32FC1, cv::Scalar(0.5));
    photo.colRange(44, 48).setTo(cv::Scalar(bar));
    depth.colRange(44, 48).setTo(0.9F);
    photo.colRange(48, 96).setTo(cv::Scalar(wall));
    depth.colRange(48, 96).setTo(0.1F);
    for (const cv::Mat& view : {rendered(photo, depth, 0.5, 25),
                                mirrored(rendered(mirrored(photo), mirrored(depth), 0.5, -25))}) {
        for (int x = 0; x < 96; ++x) {
            const cv::Vec3b expected = x < 34 ? board : x < 38 ? bar : x < 44 ? board : wall;
            if (x == 44) continue; // the board's border
            EXPECT_EQ(view.at<cv::Vec3b>(2, x), expected) << x;
        }
    }
}

// A row of flat things of one colour each.
struct FlatThing {
    int first;
    int last;
    float depth;
    cv::Vec3b color;
};

std::vector<FlatThing> randomThings(cv::RNG& rng, int width) {
    std::vector<FlatThing> things;
    for (int x = 0; x < width;) {
        const int last = std::min(x + rng.uniform(3, 24), width - 1);
        const float depth = 0.1F * static_cast<float>(rng.uniform(0, 11));
        if (things.empty() || things.back().depth != depth) {
            const cv::Vec3b color(cv::saturate_cast<uchar>(rng.uniform(0, 256)),
                                  cv::saturate_cast<uchar>(rng.uniform(0, 256)),
                                  cv::saturate_cast<uchar>(rng.uniform(0, 256)));
            things.push_back({x, last, depth, color});
            x = last + 1;
        }
    }
    return things;
}

// What a pixel shows: the nearest of all things that reach it. A thing is known to continue to the
// left behind nearer ones. @return null near an end of any thing
const FlatThing* nearestAt(const std::vector<FlatThing>& things, int x, double shift,
                           double focus) {
    constexpr double kClear = 2.5; // px
    const FlatThing* nearest = nullptr;
    for (std::size_t i = 0; i < things.size(); ++i) {
        const FlatThing& thing = things[i];
        const double column = x + shift * (static_cast<double>(thing.depth) - focus);
        int hidden = thing.first; // the first column that it may cover
        for (std::size_t k = i; k-- > 0 && things[k].depth > thing.depth;)
            hidden = things[k].first;
        if (hidden == 0) hidden = -1000; // beside the frame
        const int last = i + 1 == things.size() ? 1000 : thing.last;
        for (const int end : {hidden, thing.first, last})
            if (std::abs(column - end) < kClear) return nullptr;
        if (column < hidden || column > last) continue;
        if (nearest == nullptr || thing.depth > nearest->depth) nearest = &thing;
    }
    return nearest;
}

TEST(ViewsLayered, ThinThingsBeforeManyOthersShowTheNearestOfThem) {
    const int width = 150;
    cv::RNG rng(4);
    LayeredSettings options;
    options.edgeDilationPixels = 0;
    options.reachPixels = 40;
    options.fill = LayeredFill::Continue; // else close surfaces mix their colours
    int compared = 0;
    int wrong = 0;
    for (int round = 0; round < 300; ++round) {
        const std::vector<FlatThing> things = randomThings(rng, width);
        cv::Mat photo(1, width, CV_8UC3);
        cv::Mat depth(1, width, CV_32FC1);
        for (const FlatThing& thing : things) {
            photo.colRange(thing.first, thing.last + 1).setTo(cv::Scalar(thing.color));
            depth.colRange(thing.first, thing.last + 1).setTo(thing.depth);
        }
        const double shift = rng.uniform(10.0, 40.0);
        const cv::Mat view = rendered(photo, depth, 0.5, shift, options);
        for (int x = 0; x < width; ++x) {
            const FlatThing* const nearest = nearestAt(things, x, shift, 0.5);
            if (nearest == nullptr) continue;
            ++compared;
            if (view.at<cv::Vec3b>(0, x) != nearest->color) ++wrong;
        }
    }
    EXPECT_GT(compared, 5000);
    EXPECT_EQ(wrong, 0);
}

// The best guess of a texture far behind a border is its mean; it deviates from every other guess.
TEST(ViewsLayered, WideHolesShowTheMeanOfATextureWithoutStreaks) {
    const cv::Size size(240, 160);
    cv::Mat photo = randomPicture(size, CV_8UC3, 4, 60, 200);
    cv::GaussianBlur(photo, photo, {}, 1);
    cv::Mat depth(size, CV_32FC1, cv::Scalar(0));
    const cv::Rect board(100, 0, 60, size.height);
    photo(board).setTo(cv::Scalar(20, 20, 250));
    depth(board).setTo(1);
    const cv::Rect hole(116, 8, 28, 144); // 16 px and more from what can be seen
    for (const int side : {1, -1}) {
        const cv::Mat view = rendered(photo, depth, 0, side * 48);
        const cv::Rect wall(side > 0 ? 170 : 10, 8, 60, 144);
        cv::Scalar meanOfWall;
        cv::Scalar deviationOfWall;
        cv::meanStdDev(photo(wall), meanOfWall, deviationOfWall);
        cv::Scalar meanOfHole;
        cv::Scalar deviationOfHole;
        cv::meanStdDev(view(hole), meanOfHole, deviationOfHole);
        EXPECT_LT(cv::norm(meanOfHole, meanOfWall, cv::NORM_INF), 4) << side;
        EXPECT_LT(cv::norm(deviationOfHole), 0.32 * cv::norm(deviationOfWall)) << side;
    }
}

TEST(ViewsLayered, FillContinueRepeatsTheBackgroundsBorderPixel) {
    const cv::Mat photo = randomPhoto({64, 9});
    const Board board(0.25F, 0.75F);
    LayeredSettings options;
    options.fill = LayeredFill::Continue;
    options.edgeDilationPixels = 0;
    const cv::Mat view = rendered(photo, board.depth, 0.25, 10, options);
    for (int x = 35; x < 40; ++x) // the board moved by 5 px, from 20 .. 39 to 15 .. 34
        EXPECT_TRUE(samePicture(view.col(x), photo.col(40))) << x;
    EXPECT_TRUE(samePicture(view.colRange(40, 64), photo.colRange(40, 64)));
}

TEST(ViewsLayered, MirroredInputGivesTheMirroredViewOfTheOtherSide) {
    for (const cv::Size size : kSizes) {
        const cv::Mat photo = randomPhoto(size);
        const cv::Mat depth = blobDepth(size);
        for (const double shift : {0.7, 13.3, 150.0}) {
            for (const int mixed : {0, 2}) {
                const LayeredSettings settings = settingsFor(mixed);
                EXPECT_TRUE(samePicture(
                    mirrored(rendered(mirrored(photo), mirrored(depth), 0.4, -shift, settings)),
                    rendered(photo, depth, 0.4, shift, settings)))
                    << size;
            }
        }
        const cv::Mat stairs = quantised(depth);
        EXPECT_TRUE(
            samePicture(mirrored(withoutLevels(mirrored(stairs), 400)), withoutLevels(stairs, 400)))
            << size;
    }
}

// A slope of one level in ten px, right of it a board ten levels nearer.
cv::Mat slopeAndBoard() {
    return pictureOf<float>({400, 30}, [&](int x, int) {
        return x < 350 ? (60 + 0.1F * static_cast<float>(x)) / 255 : 105 / 255.0F;
    });
}

TEST(ViewsLayered, StaircasesOfFewLevelsBecomeSlopes) {
    constexpr float kLevel = 1 / 255.0F;
    const cv::Mat truth = slopeAndBoard();
    const cv::Mat given = quantised(truth);
    const cv::Mat result = withoutLevels(given, 400);
    EXPECT_GT(cv::norm(given, truth, cv::NORM_INF), 0.49 * kLevel);
    EXPECT_LE(cv::norm(result, given, cv::NORM_INF), 0.501 * kLevel);
    const cv::Range slope(40, 310);
    EXPECT_LT(cv::norm(result.colRange(slope), truth.colRange(slope), cv::NORM_INF), 0.1 * kLevel);
    EXPECT_TRUE(samePicture(result.colRange(350, 400), given.colRange(350, 400))); // steps stay
    LayeredSettings options;
    options.reachPixels = 400;
    const cv::Mat photo = randomPhoto(given.size());
    const LayeredScene scene = layeredScene(photo, result, 0.3, options);
    for (const LayeredRow& row : scene.rows[0])
        EXPECT_EQ(row.surfaces.size(), 2U);
}

TEST(ViewsLayered, DepthWithoutVisibleLevelsStaysAsItIs) {
    const auto stays = [](const cv::Mat& depth, double reach) {
        return withoutLevels(depth, reach).data == depth.data;
    };
    EXPECT_TRUE(stays(quantised(slopeAndBoard()), 32)); // 1/8 px per level
    EXPECT_FALSE(stays(quantised(slopeAndBoard()), 64));
    EXPECT_TRUE(stays(slopeAndBoard(), 400)); // more values than 8 bits have
    EXPECT_TRUE(stays(Board(0.2F, 0.8F).depth, 400));
    EXPECT_TRUE(stays(cv::Mat(9, 9, CV_32FC1, cv::Scalar(0.5)), 400));
}

TEST(ViewsLayered, MemoryIsBoundedForDepthThatIsNoise) {
    const cv::Mat depth = randomDepth({600, 8}, 3);
    LayeredSettings options;
    options.reachPixels = 1e6;
    const LayeredScene scene = layeredScene(randomPhoto(depth.size()), depth, 0.5, options);
    for (const LayeredRow& row : scene.rows[0])
        EXPECT_LT(row.strips.size(), 4 * (600U * 12 + 3 * 4096));
}

// What the search must find, by trying all columns: from the right, the first that appears at x or
// left of it, or whose border reaches x.
struct Found {
    int column = -1;
    bool inside = false; // between two columns of one surface
    double place = 0;
};

Found slowSearch(const LayeredScene& scene, int row, int direction, float x, float shift) {
    const LayeredTables tables = scene.tables(row);
    const std::int16_t* words = tables.words + direction * tables.stride;
    const LayeredRow& own = scene.rows[direction][static_cast<std::size_t>(row)];
    const float unit = shift * tables.scale;
    const auto placeOf = [&](int column) {
        return static_cast<float>(column) - unit * static_cast<float>(wordOffset(words[column]));
    };
    for (int column = scene.width - 1; column >= 0; --column) {
        const float place = placeOf(column);
        const bool border = place - kEndReach <= x &&
                            std::any_of(own.surfaces.begin(), own.surfaces.end(),
                                        [&](const LayeredSurface& surface) {
                                            return surface.first == column && surface.hidden == 0;
                                        });
        if (place > x && !border) continue;
        Found found;
        found.column = column;
        found.inside = place <= x && (words[column] & kLastFlag) == 0;
        if (found.inside) {
            const double next = static_cast<double>(placeOf(column + 1));
            const double from = static_cast<double>(place);
            found.place = column + (static_cast<double>(x) - from) / (next - from);
        }
        return found;
    }
    return {};
}

// One channel of a row of the photo as the kernels read it; see LayeredSurfaces::strips.
std::vector<std::uint8_t> planeOf(const LayeredScene& scene, const cv::Mat& photo, int row,
                                  int channel, int (&strips)[2]) {
    std::vector<std::uint8_t> plane(2 * static_cast<std::size_t>(scene.stride()));
    for (int x = 0; x < photo.cols; ++x) {
        const std::uint8_t value = photo.at<cv::Vec3b>(row, x)[channel];
        plane[static_cast<std::size_t>(x)] = value;
        plane[static_cast<std::size_t>(scene.stride() + photo.cols - 1 - x)] = value;
    }
    for (int direction = 0; direction < 2; ++direction) {
        strips[direction] = static_cast<int>(plane.size());
        const auto& painted = scene.rows[direction][static_cast<std::size_t>(row)].strips;
        for (std::size_t i = static_cast<std::size_t>(channel); i < painted.size(); i += 4)
            plane.push_back(painted[i]);
    }
    plane.push_back(0);
    return plane;
}

// What a place shows, in long double: its own colour and, at a soft border, the change of what is
// behind it.
class SlowColour {
  public:
    SlowColour(const LayeredScene& scene, const cv::Mat& photo, int row, int channel)
        : scene_(scene), photo_(photo), row_(row), channel_(channel) {}

    // @param place in a row @param direction of that row @param x place of the px in the view
    // @param shift of the view, px
    double at(long double place, int direction, long double x, double shift) const {
        const long double last = scene_.width - 1;
        const long double p = direction == 0 ? place : last - place;
        const long double own = photoAt(p, 0, last);
        const long double share = shareAt(p);
        if (share == 0) return static_cast<double>(own);
        const std::vector<LayeredSurface>& surfaces = surfacesOf(0);
        std::size_t k = 0;
        while (surfaces[k].last < p)
            ++k;
        const bool isLeft = p < surfaces[k].first + surfaces[k].softLeft;
        const LayeredSurface& behind = surfaces[isLeft ? k - 1 : k + 1];
        const int end = isLeft ? behind.last : behind.first;
        const long double offset =
            static_cast<long double>(scene_.scale) * wordOffset(scene_.tables(row_).words[end]);
        const auto behindAt = [&](long double column) {
            const long double hidden = isLeft ? column - end : end - column;
            if (hidden <= 0) return photoAt(column, behind.first, behind.last);
            return paintedAt(isLeft ? 1 : 0, isLeft ? surfaces.size() - k : k + 1, hidden);
        };
        const long double change =
            behindAt(x + static_cast<long double>(shift) * offset) - behindAt(p);
        return static_cast<double>(std::clamp(own + share * change, 0.0L, 255.0L));
    }

  private:
    const std::vector<LayeredSurface>& surfacesOf(int direction) const {
        return scene_.rows[direction][static_cast<std::size_t>(row_)].surfaces;
    }
    template <class F>
    static long double between(long double place, const F& valueAt) {
        const int left = static_cast<int>(std::floor(place));
        const long double part = place - left;
        return part == 0 ? valueAt(left) : valueAt(left) * (1 - part) + valueAt(left + 1) * part;
    }
    long double photoAt(long double column, long double first, long double last) const {
        return between(std::clamp(column, first, last), [&](int x) {
            return static_cast<long double>(photo_.at<cv::Vec3b>(row_, x)[channel_]);
        });
    }
    long double shareAt(long double column) const {
        if (scene_.shares.empty()) return 0;
        return between(column, [&](int x) {
            return static_cast<long double>(scene_.shares.at<std::uint8_t>(row_, x)) / 256;
        });
    }
    long double paintedAt(int direction, std::size_t surface, long double distance) const {
        const LayeredSurface& painted = surfacesOf(direction)[surface];
        const auto& strips = scene_.rows[direction][static_cast<std::size_t>(row_)].strips;
        return between(std::min(distance, static_cast<long double>(painted.hidden)), [&](int k) {
            return static_cast<long double>(
                strips[static_cast<std::size_t>(4 * painted.hiddenAt(k) + channel_)]);
        });
    }

    const LayeredScene& scene_;
    const cv::Mat& photo_;
    int row_;
    int channel_;
};

std::vector<cv::Mat> depthsToSearch(cv::Size size) {
    const cv::Mat noise = randomDepth(size, 7);
    const cv::Mat waves = pictureOf<float>(size, [&](int x, int y) {
        return 0.5F + 0.3F * std::sin(0.09F * static_cast<float>(x + y));
    });
    cv::Mat thin(size, CV_32FC1, cv::Scalar(0.1)); // bars of one and two px beside each other
    cv::RNG rng(5);
    for (int y = 0; y < size.height; ++y) {
        for (int x = 5; x + 4 < size.width; x += 40) {
            for (int k = 0; k < 4; ++k)
                thin.at<float>(y, x + k) = rng.uniform(0.2F, 1.0F);
            if (y % 2 == 0) thin.at<float>(y, x + 1) = thin.at<float>(y, x);
        }
    }
    return {noise, waves, blobDepth(size), blobDepth(size, 5), blobDepth(size, 8), thin};
}

// Pixel by pixel, at columns and between them: the slow search finds what trying all columns finds,
// and the kernels give the colour there, wherever the pixel is and whatever is in front of it.
TEST(ViewsLayered, KernelsGiveTheColourThatTryingAllColumnsFinds) {
    const cv::Size size(211, 12);
    cv::Mat photo = randomPhoto(size);
    cv::GaussianBlur(photo, photo, {}, 0.6); // with clear and with soft borders
    const std::vector<int> columns = numbersFrom(0, size.width);
    std::vector<float> shifts(columns.size() + kRowPadding);
    std::vector<std::uint8_t> values(columns.size() + kRowPadding);
    cv::RNG rng(9);
    int softCount = 0;
    int number = 0;
    for (const cv::Mat& depth : depthsToSearch(size)) {
        for (const int kind : {0, 1, 2, 3}) {
            const double tear = kind < 2 ? 1.0 : 3.0;
            std::vector<std::uint8_t> parts(columns.size());
            for (std::size_t i = 0; kind % 2 == 1 && i + 1 < columns.size(); ++i)
                parts[i] = static_cast<std::uint8_t>(rng.uniform(0, 256));
            LayeredSettings options = settingsFor(number++ / 2 % 3);
            options.reachPixels = 25;
            options.tearPixels = tear;
            const LayeredScene scene = layeredScene(photo, depth, 0.4, options);
            const auto renderer = makeLayeredRenderer(photo, depth, 0.4, options);
            const double largest = tear > 2 ? 90 : 25; // also beyond the reach
            const auto sampler = renderer->sampler(columns, parts, largest);
            for (int y = 0; y < size.height; ++y) {
                const int channel = y % 3;
                for (std::size_t i = 0; i < columns.size(); ++i) {
                    shifts[i] = static_cast<float>(rng.uniform(-largest, largest));
                    if (i % 10 == 0) shifts[i] = i % 20 == 0 ? 25 : -25;
                    // within the reach, shifts are whole steps
                    if (tear < 2) shifts[i] = std::round(shifts[i] / 25 * 16384) * 25 / 16384;
                }
                sampler->open(y);
                ASSERT_FALSE(sampler->still());
                sampler->sample(channel, shifts.data(), values.data());
                int strips[2];
                const std::vector<std::uint8_t> plane = planeOf(scene, photo, y, channel, strips);
                const LayeredSearch search(scene, y, scene.tables(y), strips);
                const SlowColour slow(scene, photo, y, channel);
                for (int x = 0; x < size.width; ++x) {
                    const float shift = shifts[static_cast<std::size_t>(x)];
                    const int direction = shift < 0 ? 1 : 0;
                    const float at = static_cast<float>(x) +
                                     static_cast<float>(parts[static_cast<std::size_t>(x)]) / 256;
                    const float own = direction == 0 ? at : static_cast<float>(size.width - 1) - at;
                    const LayeredCovers pixel =
                        search.at(direction, own, std::abs(shift), size.width - 1);
                    const auto colourAt = [&](std::int32_t place) {
                        if (place >= strips[0] << kSubColumnBits)
                            return static_cast<double>(sampleAt(plane.data(), place));
                        const long double inRow = place / 256.0L - direction * scene.stride();
                        return slow.at(inRow, direction, static_cast<long double>(at),
                                       static_cast<double>(shift));
                    };
                    const Found found = slowSearch(scene, y, direction, own, std::abs(shift));
                    if (found.inside) {
                        ASSERT_EQ(pixel.count, 1);
                        ASSERT_NEAR(pixel.place[0] / 256.0 - direction * scene.stride(),
                                    found.place, 0.5 / 256 + 1e-4)
                            << x << " " << y;
                    }
                    const double value = values[static_cast<std::size_t>(x)];
                    // also behind a border that does not reach the pixel
                    const bool inside = pixel.count == 1 && pixel.place[0] < strips[0]
                                                                                 << kSubColumnBits;
                    if (!found.inside && !inside) {
                        double expected = 0;
                        for (int i = pixel.count; i-- > 0;) {
                            const double part =
                                i + 1 == pixel.count ? 1 : pixel.coverage[i] / 256.0;
                            expected = part * colourAt(pixel.place[i]) + (1 - part) * expected;
                        }
                        // roundings of each cover and of the places behind it, 1/512 px
                        ASSERT_NEAR(value, expected, 2.5) << x << " " << y << " " << shift;
                        continue;
                    }
                    // where depth follows a line, the place is that of the line
                    constexpr int kTolerance = 256 / 32 + 1; // 1/32 px and rounding
                    double least = 255;
                    double most = 0;
                    const int begin = direction * scene.stride() << kSubColumnBits;
                    const int end = begin + ((size.width - 1) << kSubColumnBits);
                    for (int off = -kTolerance; off <= kTolerance; ++off) {
                        const int place = std::clamp(pixel.place[0] + off, begin, end);
                        const double near = colourAt(place);
                        if (near != sampleAt(plane.data(), place)) ++softCount;
                        least = std::min(least, near);
                        most = std::max(most, near);
                    }
                    ASSERT_TRUE(least - 1.5 <= value && value <= most + 1.5)
                        << x << " " << y << " " << shift << ": " << value;
                }
            }
        }
    }
    EXPECT_GT(softCount, 1000);
}

// A near thing at the focus does not move, but what is behind its soft borders does, wherever they
// lie among the pixels that are processed together.
TEST(ViewsLayered, SoftBordersOfThingsAtTheFocusShowWhatMovesBehindThem) {
    cv::Mat photo = randomPhoto({200, 6});
    cv::GaussianBlur(photo, photo, {}, 1.5);
    LayeredSettings hard = settingsFor(2);
    hard.softBorders = false;
    for (int first = 60; first < 97; ++first) {
        cv::Mat depth(photo.size(), CV_32FC1, cv::Scalar(0.25));
        depth.colRange(first, first + 50).setTo(0.75);
        const cv::Mat view = rendered(photo, depth, 0.75, 9, settingsFor(2));
        EXPECT_GT(cv::norm(view.colRange(first, first + 50),
                           rendered(photo, depth, 0.75, 9, hard).colRange(first, first + 50)),
                  0);
        EXPECT_TRUE(samePicture(
            mirrored(rendered(mirrored(photo), mirrored(depth), 0.75, -9, settingsFor(2))), view))
            << first;
        const std::vector<int> columns = numbersFrom(31, 137); // other blocks
        const auto renderer = makeLayeredRenderer(photo, depth, 0.75, settingsFor(2));
        const auto sampler = renderer->sampler(columns, {}, 32);
        const std::vector<float> shifts(columns.size() + kRowPadding, 9);
        std::vector<std::uint8_t> values(columns.size() + kRowPadding);
        sampler->open(3);
        sampler->sample(1, shifts.data(), values.data());
        for (std::size_t i = 0; i < columns.size(); ++i)
            ASSERT_EQ(values[i], view.at<cv::Vec3b>(3, columns[i])[1]) << first << " " << i;
    }
}

// Left picture and true disparity to the right picture.
struct Floor {
    const char* scene;
    double wholePsnr;
    double wholeSsim;
    double insidePsnr;
    double insideSsim;
};

TEST(ViewsLayered, ReachesItsFloorsOnStereoPairs) {
    ALTIRO3D_REQUIRE_DATA("middlebury");
    for (const Floor& floor :
         {Floor{"Venus", 31.4, .893, 33.3, .903}, Floor{"Cones", 23.1, .815, 26.5, .856},
          Floor{"Teddy", 27.3, .850, 29.7, .874}, Floor{"Art", 24.6, .849, 26.4, .885},
          Floor{"Books", 23.1, .884, 28.5, .925}, Floor{"Motorcycle", 24.5, .903, 24.8, .908}}) {
        const StereoScene scene = middleburyScene(floor.scene);
        LayeredSettings options;
        options.reachPixels = scene.largestDisparity;
        const cv::Mat view = rendered(scene.photo, scene.depth, 0, scene.largestDisparity, options);
        const ViewAccuracy accuracy = compareViews(view, scene.truth, scene.band());
        EXPECT_GT(accuracy.psnrWhole, floor.wholePsnr) << floor.scene;
        EXPECT_GT(accuracy.ssimWhole, floor.wholeSsim) << floor.scene;
        EXPECT_GT(accuracy.psnrInside, floor.insidePsnr) << floor.scene;
        EXPECT_GT(accuracy.ssimInside, floor.insideSsim) << floor.scene;
    }
}

} // namespace
} // namespace altiro3D::test
