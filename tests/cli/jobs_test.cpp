// What photo2native and video2native make of a command line: its job and plan, without a run.

#include "altiro3D/display.hpp"
#include "altiro3D/image_io.hpp"
#include "photo/photo_plan.hpp"
#include "sandbox.hpp"
#include "support/video.hpp"
#include "video/video_options.hpp"

#include <functional>
#include <opencv2/core.hpp>

namespace altiro3D::tools {

void addPhotoOptions(CommandLine& commandLine); // photo2native.cpp
void addVideoOptions(CommandLine& commandLine); // video2native.cpp

} // namespace altiro3D::tools

namespace altiro3D::test {

namespace fs = std::filesystem;

namespace {

using namespace tools;

struct Row {
    std::string call;
    std::string expected;
};

// Rows of a table: "arguments => expected", one in a line.
std::vector<Row> rowsOf(const std::string& table) {
    std::vector<Row> rows;
    for (const std::string& line : lines(table)) {
        const std::size_t arrow = line.find(" => ");
        if (arrow != std::string::npos)
            rows.push_back({line.substr(0, arrow), line.substr(arrow + 4)});
    }
    EXPECT_GT(rows.size(), 1U);
    return rows;
}

// A studio that is the working directory.
class Jobs : public ::testing::Test {
  protected:
    Jobs() : before_(fs::current_path()) {
        fs::current_path(studio_.work());
        display_.calibration = readCalibration("small.json");
        display_.quilt = smallLayout();
        display_.files = {"small.json"};
        for (const char* folder : {"in", "out", "more", "empty"})
            fs::create_directory(folder);
        for (const char* copy :
             {"in/a.png", "in/b.png", "more/photo.png", "photo2.png", "photo.ppm"})
            fs::copy("photo.png", copy);
        for (const char* file :
             {"a.map", "clip.mp4", "depth.mp4", "film.MTS", "o.avi", "old.png", "f_L.png"})
            spill(file, "any bytes");
        fs::create_symlink("photo.png", "link.mp4");
        spill("camera.json", R"({"fx": 80, "fy": 80, "cx": 44.5, "cy": 59.5, "zNear": 1, "zFar": 9,
                                 "baseline": 0.2})");
    }
    void TearDown() override { fs::current_path(before_); }

    static void parse(CommandLine& commandLine, Arguments call) {
        call.insert(call.begin(), commandLine.name());
        commandLine.parse(call);
    }
    static PhotoJob photo(const Arguments& call) {
        CommandLine commandLine("photo2native", "");
        addPhotoOptions(commandLine);
        parse(commandLine, call);
        return photoJob(commandLine);
    }
    static VideoJob video(const Arguments& call) {
        CommandLine commandLine("video2native", "");
        addVideoOptions(commandLine);
        parse(commandLine, call);
        return videoJob(commandLine);
    }
    PhotoPlan planOf(const PhotoJob& job) {
        messages_.leaveStandardOutput();
        PhotoPlan plan = planPhotos(job, display_, smallLayout(), listPhotos(job, messages_));
        checkedOutputs(job, plan, display_, 2);
        return plan;
    }
    // The outputs of all photos, in order.
    std::string outputsOf(const Arguments& call) {
        std::string all;
        for (const PhotoItem& item : planOf(photo(call)).items)
            for (const fs::path& file : tools::outputsOf(item, 2))
                all += (all.empty() ? "" : " ") + file.string();
        return all;
    }
    template <class Failure>
    static std::string sentence(const std::function<void()>& act) {
        try {
            act();
        } catch (const Failure& error) {
            return sentenceOf(error);
        } catch (const std::exception& error) {
            return std::string("another kind of error: ") + error.what();
        }
        return "no error";
    }
    template <class Failure>
    void expectFailures(const char* table, const std::function<void(const Arguments&)>& act) {
        for (const Row& row : rowsOf(table)) {
            EXPECT_TRUE(
                holds(sentence<Failure>([&] { act(Arguments(row.call.c_str())); }), row.expected))
                << row.call;
        }
        EXPECT_EQ(slurp("photo.png"), photo_);
        EXPECT_FALSE(fs::exists("a.png"));
    }

    SmallStudio studio_;
    std::string photo_ = slurp(studio_ / "photo.png");
    fs::path before_;
    ChosenDisplay display_;
    Messages messages_{"photo2native", false};
};

} // namespace

TEST_F(Jobs, WrongPhotoCallsAreExplained) {
    expectFailures<UsageError>(
        R"(
photo.png => expected PHOTO and OUT, got 1 name
-d photo.png a.png => expected PHOTO DEPTH OUT, got 2 names
--save-quilt photo.png a.png => got 1 name (--save-quilt took photo.png)
small.json photo.png a.png => small.json: is not a picture, expected a photo; a calibration is given with -c
a.map photo.png a.png => a.map: is not a picture, expected a photo; a look-up table is given with -m
clip.mp4 a.png => clip.mp4: is not a picture, expected a photo; video2native makes Natives of videos
film.MTS a.png => film.MTS: is not a picture, expected a photo; video2native makes Natives of videos
a.avi a.png => a.avi: is not a picture, expected a photo; video2native makes Natives of videos
a.webm a.png => a.webm: is not a picture, expected a photo; video2native makes Natives of videos
a.3gp a.png => a.3gp: is not a picture, expected a photo; video2native makes Natives of videos
photo.png a.mp4 => a.mp4: unknown picture extension, expected .png; video2native makes videos
-m small.json photo.png a.png => small.json: is a calibration, expected a look-up table (.map); calibrations are given with -c
--strenght 5 photo.png a.png => did you mean --strength?
--methods=fast photo.png a.png => did you mean --method?
-strength 5 photo.png a.png => long options have two dashes: --strength
--quite-another photo.png a.png => Unknown option 'quite-another'
-d --rgbd left photo.png depth.png a.png => -d and --rgbd exclude each other
-d -n x.onnx photo.png depth.png a.png => -d and -n exclude each other
-d --network-size 64 photo.png depth.png a.png => -d and --network-size exclude each other
--rgbd left -l photo.png a.png => --rgbd and -l exclude each other
--rgbd up photo.png a.png => --rgbd is "up", expected right, left, top or bottom, with :full or :squeezed if needed
--rgbd right:half photo.png a.png => --rgbd is "right:half", expected right, left, top or bottom, with :full or :squeezed
--rgbd right: photo.png a.png => --rgbd is "right:", expected right, left, top or bottom
--rgbd :full photo.png a.png => --rgbd is ":full", expected right, left, top or bottom
--rgbd right:full:full photo.png a.png => --rgbd is "right:full:full", expected right, left, top or bottom
--depth-kind metric photo.png a.png => --depth-kind describes given depth, expected -d or --rgbd with it
-d --depth-kind near photo.png depth.png a.png => --depth-kind is "near", expected near-white, far-white, metric or metric:SCALE (units of a metre)
-d --depth-kind metric:0 photo.png depth.png a.png => --depth-kind is "metric:0", expected near-white, far-white, metric or metric:SCALE (units of a metre)
-d --depth-kind metric:5,5 photo.png depth.png a.png => --depth-kind is "metric:5,5", expected near-white, far-white
--net-profile x.json photo.png a.png => --net-profile describes a network file, expected -n FILE
-l --net-profile x.json photo.png a.png => -l and --net-profile exclude each other
-l -n x.onnx --net-profile x.json photo.png a.png => -l and --net-profile exclude each other
-n cues photo.png a.png => -n cues: depth without a network no longer exists, expected -n altiro3d
--network-size 15 photo.png a.png => --network-size is "15", expected a number 16..4096
--stereo files photo.png a.png => expected LEFT RIGHT OUT, got 2 names
--stereo sideways photo.png a.png => --stereo is "sideways", expected left-right, right-left, top-bottom or bottom-top
--stereo left-right:half photo.png a.png => --stereo is "left-right:half", expected left-right, right-left, top-bottom or bottom-top
--stereo files:full photo.png a.png => --stereo is "files:full", expected left-right, right-left, top-bottom or bottom-top
--stereo left-right --rgbd right photo.png a.png => --stereo and --rgbd exclude each other
--stereo-layout tb photo.png a.png => describes --save-stereo
--save-stereo e.mp4 photo.png => e.mp4
--strength -1 photo.png a.png => --strength is "-1", expected a number 0..100
--focus 1.01 photo.png a.png => --focus is "1.01", expected a number 0..1
--fit fill photo.png a.png => --fit is "fill", expected cover, contain, stretch or auto
--center 0.5 photo.png a.png => --center is "0.5", expected two numbers 0..1 with a comma
--center 0.5,2 photo.png a.png => --center is "0.5,2", expected two numbers
--center 0.5,0.5,1 photo.png a.png => --center is "0.5,0.5,1", expected two numbers
--center 0,0 --fit contain photo.png a.png => --center has no effect, as --fit contain shows all of the picture
--center 0,0 --fit auto photo.png a.png => --fit auto chooses the centre itself, expected no --center with it
--zoom 0.5 photo.png a.png => --zoom is "0.5", expected a number 1..1000
--sampling cubic photo.png a.png => --sampling is "cubic", expected nearest or linear
--method slow photo.png a.png => --method is "slow", expected layered, fast or real
--method Fast photo.png a.png => --method is "Fast", expected layered, fast or real
--refine 17 photo.png a.png => --refine is "17", expected a whole number 0..16
--fill paint photo.png a.png => --fill is "paint", expected background or continue
--borders sharp photo.png a.png => --borders is "sharp", expected soft or hard
--inpaint-from before photo.png a.png => --inpaint-from is "before", expected around or behind
--refine 2 photo.png a.png => --refine is an option of method fast, but layered is used; expected --method fast
-g --fill continue photo.png a.png => --fill is an option of method layered, but real is used; expected --method layered
--method fast --inpaint-from behind photo.png a.png => --inpaint-from is an option of method real, but fast is used
-g --method fast photo.png a.png => -g means --method real, expected no other --method
-g --method layered photo.png a.png => -g means --method real, expected no other --method
--continuous -g photo.png a.png => --continuous reads single sub-pixels, but method real makes whole views only; expected --method layered or fast
--continuous --method real photo.png a.png => expected --method layered or fast
--continuous -m a.map photo.png a.png => --continuous needs the exact directions of the lenses, but a map (-m) has whole views only; expected -c instead of -m
--continuous --view-filter linear photo.png a.png => --continuous needs no blending: --view-filter and --sampling blend views of a quilt; expected it without them
--continuous --sampling linear photo.png a.png => expected it without them
-m a.map --invert off photo.png a.png => -m and --invert exclude each other
-m a.map --view-filter linear photo.png a.png => -m and --view-filter exclude each other
-m a.map --sampling linear photo.png a.png => -m and --sampling exclude each other
--camera camera.json photo.png a.png => expected -g
--camera camera.json --method fast photo.png a.png => expected -g
-g --camera camera.json --strength 5 photo.png a.png => exclude each other
-g --camera camera.json photo.png camera.json => camera.json
-g --camera camera.json --report camera.json photo.png a.png => is also an input
--budget 0 photo.png a.png => --budget is "0"
--budget 1e7 photo.png a.png => --budget is "1e7"
--budget 100 --method fast photo.png a.png => --budget and --method exclude each other
--budget 100 -g photo.png a.png => --budget and -g exclude each other
--budget 100 --refine 1 photo.png a.png => --budget and -
--budget 100 --fill continue photo.png a.png => --budget and -
--budget 100 --borders hard photo.png a.png => --budget and -
--budget 100 --inpaint-from behind photo.png a.png => --budget and -
--budget 100 --camera camera.json photo.png a.png => --budget and -
--save-depth-size 500 photo.png a.png => --save-depth-size is the size of saved depth, expected --save-depth
--save-photo-with-depth w.png photo.png a.png => w.png: is not the name of a JPEG, expected FILE.jpg
--seconds 1 photo.png a.png => expected --lg with them
--turns 1 photo.png a.png => expected --lg with them
--fps 25 photo.png a.png => expected --lg with them
--size 64x64 photo.png a.png => expected --lg with them
--lg a.gif photo.png a.png => a.gif: no video format has this extension
--lg a photo.png a.png => expected .mp4
--lg a.mp4 --save-depth a.mp4 photo.png a.png => a.mp4
--lg a.mp4 --size 63x64 photo.png a.png => --size is "63x64", expected WIDTHxHEIGHT
--lg a.mp4 --size 14x64 photo.png a.png => even numbers 16..16384
--lg a.mp4 --size 64 photo.png a.png => even numbers
--lg= photo.png a.png => --lg is empty
--lg a.mp4 --size 16x16000 photo.png a.png => 1:100..100:1
--lg a.mp4 --fps 0 photo.png a.png => --fps is "0", expected a number 1..240
--lg a.mp4 --turns 1.5 photo.png a.png => expected a whole number 1..1000
--lg a.mp4 --seconds x photo.png a.png => expected a number 0.1..600
--bleed 3 photo.png a.png => --bleed is for prints, expected --print with it
--print --plan plan photo.png out => --print and --plan exclude each other
--print photo.png a.jpg => a.jpg: is not the name of a print, expected .png, .tif or .pdf
--go go -c small.json photo.png => --go and -c exclude each other
--go go -q 2x3 photo.png => --go and -q exclude each other
--go go --save-quilt a.png photo.png => --go and --save-quilt exclude each other
--go go --lg a.mp4 photo.png => --go and --lg exclude each other
--go go => expected PHOTO, got 0 names
--each 5 photo.png a.png => --each applies to --go and --bridge
--skip-existing -y photo.png a.png => exclude each other
--skip-existing photo.png photo.png => is also an input
--progress json photo.png - => standard output
--report - photo.png a.png => only the last name
- - out => - stands for one picture
photo.png depth.png - => - stands for one picture
photo.png photo2.png a.png => a.png: names one file, expected a directory
-y photo.png photo2.png quilt.png => expected a directory
photo.png depth.png missing.png => or -d with a photo and its depth
photo.png more/photo.png out2 => is written twice
-d photo.png depth.png photo2.png out => -d takes pairs PHOTO DEPTH and one output, got 4 names
--save-quilt a.png photo.png out => --save-quilt a.png: names one file, expected a directory
--save-depth a.png photo.png out => --save-depth a.png: names one file, expected a directory
--save-rgbd a.png photo.png out => --save-rgbd a.png: names one file, expected a directory
--lg a.mp4 photo.png out => --lg a.mp4: names one file, expected a directory
-y --lg link.mp4 photo.png a.png => is also an input
--save-depth a.png -d photo.png depth.png a.png => a.png: is written twice
--save-rgbd ./a.png -d photo.png depth.png a.png => is written twice
--report a.png -d photo.png depth.png a.png => is written twice
--save-depth b.png --save-rgbd b.png -d photo.png depth.png a.png => is written twice
)",
        [this](const Arguments& call) { planOf(photo(call)); });
}

TEST_F(Jobs, PhotosThatCannotBeReadOrWrittenAreNamedBeforeAnyWork) {
    spill("b_qs3x2a0.75.png", "precious");
    fs::create_directory("v");
    spill("v/view_1.png", "precious");
    expectFailures<Error>(R"(
photo.png old.png => old.png: exists, and is not marked as a Native (inputs come first, then outputs)
--save-depth old.png photo.png a.png => old.png: exists
--save-rgbd old.png photo.png a.png => old.png: exists
--save-quilt b.png photo.png a.png => b_qs3x2a0.75.png: exists
--save-views v photo.png a.png => view_1.png: exists
--report old.png photo.png a.png => old.png: exists
--save-quilt q_qs5x9.png photo.png a.png => q_qs5x9.png
none.png a.png => none.png: does not exist
empty out3 => empty: holds no pictures to convert, expected photos
none.png old.png => none.png: does not exist
photo.png nowhere/a.png => there is no directory
--lg nowhere/a.mp4 photo.png a.png => there is no directory
--lg depth.mp4 photo.png a.png => depth.mp4: exists
--save-stereo f.png --stereo-layout files photo.png => f_L.png: exists
--go photo.png photo.png => photo.png: is a file
)",
                          [this](const Arguments& call) { planOf(photo(call)); });
}

TEST_F(Jobs, EachPhotoHasItsOutputs) {
    for (const auto& [call, expected] : rowsOf(R"(
photo.png a.png => a.png
photo.png out => out/photo_native.png
photo.png more => more/photo_native.png
photo.png photo2.png new => new/photo_native.png new/photo2_native.png
-d photo.png depth.png photo2.png depth.png new => new/photo_native.png new/photo2_native.png
in new => new/a_native.png new/b_native.png
photo.png photo.ppm out => out/photo.png_native.png out/photo.ppm_native.png
-d in out new => new/a_native.png new/b_native.png
--save-quilt q.png photo.png a.png => a.png q_qs3x2a0.75.png
--save-quilt q_qs3x2a1.5.png photo.png a.png => a.png q_qs3x2a1.5.png
--save-quilt q --save-depth d --save-rgbd r --lg l --save-photo-with-depth p in/a.png out => out/a_native.png q/a_qs3x2a0.75.png d/a_depth.png r/a_rgbd.png p/a_with_depth.jpg l/a.mp4
--save-views v photo.png a.png => a.png v/view_0.png v/view_1.png
--save-views v in/a.png out => out/a_native.png v/a_views/view_0.png v/a_views/view_1.png
--save-stereo e.png photo.png => e.png
--save-stereo e.png --stereo-layout files photo.png => e_L.png e_R.png
--save-stereo e in/a.png in/b.png out => out/a_native.png e/a_LRF.png out/b_native.png e/b_LRF.png
--save-stereo e --stereo-layout tb in => e/a_TBF.png e/b_TBF.png
--save-depth d.png photo.png => d.png
)"))
        EXPECT_EQ(outputsOf(Arguments(call.c_str())), expected) << call;
}

TEST_F(Jobs, OptionsOfPhotosBecomeFields) {
    using Job = const PhotoJob&;
    const std::pair<const char*, std::function<bool(Job)>> cases[] = {
        {"p.png a.png",
         [](Job j) { return j.scene.unasked.any() && displayUse(j) == DisplayUse::Show; }},
        {"--fit cover --focus 0.5 p.png a.png",
         [](Job j) { return !j.scene.recipe.choices.framing; }},
        {"--strength 12.5 p.png a.png",
         [](Job j) { return j.isStrengthGiven && j.scene.recipe.views.strengthPercent == 12.5; }},
        {"--strength auto p.png a.png",
         [](Job j) { return !j.isStrengthGiven && j.scene.recipe.choices.strength; }},
        {"--geometric p.png a.png",
         [](Job j) { return j.scene.recipe.views.method == ViewMethod::Real; }},
        {"-g --method real p.png a.png",
         [](Job j) { return j.scene.recipe.views.method == ViewMethod::Real; }},
        {"--borders hard p.png a.png",
         [](Job j) { return !j.scene.recipe.views.layered.softBorders; }},
        {"--keep p.png a.png", [](Job j) { return j.scene.recipe.detail == Detail::Panel; }},
        {"p.png b.png", [](Job j) { return j.scene.recipe.detail == Detail::Lens; }},
        {"--quick p.png a.png", [](Job j) { return j.scene.recipe.detail == Detail::View; }},
        {"--center 0.2,1 --zoom 1.5 p.png a.png",
         [](Job j) {
             return j.scene.recipe.framing == Framing{{0.2, 1}, 1.5};
         }},
        {"-q 4x2 -r 20x18 p.png a.png",
         [](Job j) {
             return j.quilt.grid && j.quilt.grid->columns == 2 && j.quilt.grid->rows == 4 &&
                    j.quilt.tileSize == cv::Size(18, 20);
         }},
        {"-c x.json --serial S-1 --invert on p.png a.png",
         [](Job j) {
             return j.display.calibration == "x.json" && j.display.serial == "S-1" &&
                    j.display.invert == InvertViews::On;
         }},
        {"-d --depth-kind metric:5000 p.png d.png a.png",
         [](Job j) { return j.depth.fromFiles && j.depth.kind == DepthKind::Metric; }},
        {"--rgbd top:squeezed p.png a.png",
         [](Job j) {
             return j.depth.rgbd && j.depth.rgbd->side == DepthSide::Top &&
                    j.depth.rgbd->halves == StereoHalves::Squeezed;
         }},
        {"-n x.onnx --network-size 64 p.png a.png",
         [](Job j) { return j.depth.network == "x.onnx" && j.depth.networkSize == 64; }},
        {"-n tiny p.png a.png", [](Job j) { return !j.depth.stored.useDepth; }},
        {"-n tiny --embedded-depth auto p.png a.png",
         [](Job j) { return j.depth.stored.useDepth; }},
        {"--embedded-depth off p.png a.png",
         [](Job j) { return !j.depth.stored.useDepth && !j.depth.refusesVr; }},
        {"--save-stereo e.png --stereo-layout anaglyph --stereo-swap photo.png",
         [](Job j) {
             return j.eyes.options().picture == EyesPicture::Anaglyph && j.eyes.options().swapped &&
                    j.keepsEyes && displayUse(j) == DisplayUse::None;
         }},
        {"--save-stereo e.png --strength 4 photo.png",
         [](Job j) { return !j.keepsEyes && j.eyes.options().strengthPercent == 4; }},
        {"--save-quilt q.png photo.png", [](Job j) { return displayUse(j) == DisplayUse::Quilt; }},
        {"--lg s.mp4 --seconds 2 --turns 3 --fps 25 --size 64x32 p.png a.png",
         [](Job j) {
             return j.sway.secondsPerTurn == 2 && j.sway.turns == 3 &&
                    j.sway.frameRate.value() == 25 && j.swaySize == cv::Size(64, 32);
         }},
        {"--go go --each 7.5 photo.png", [](Job j) { return j.go && j.outputs.native.empty(); }},
        {"--save-depth d.png --save-depth-size 500 p.png a.png",
         [](Job j) { return j.savedDepthSide == 500; }},
        {"-y --recursive --progress json --report r.json in out", [](Job j) {
             return j.replace && j.recursive && j.jsonProgress && j.report == "r.json" &&
                    j.given.at("report") == "r.json";
         }}};
    for (const auto& [call, isSo] : cases)
        EXPECT_TRUE(isSo(photo(call))) << call;
    for (const char* plain : {"--method layered", "--sampling nearest", "--view-filter nearest",
                              "--budget 60000", "--continuous"})
        EXPECT_EQ(photo(Arguments(plain) + Arguments("p.png a.png")).scene.recipe.detail,
                  Detail::View)
            << plain;
}

TEST_F(Jobs, WrongVideoCallsAreExplained) {
    expectFailures<UsageError>(
        R"(
clip.mp4 => expected IN and OUT, got 1 name
-d clip.mp4 o.mp4 => expected IN DEPTH OUT, got 2 names
--show clip.mp4 o.mp4 => expected IN, got 2 names
clip.mp4 o.avi => expected .mp4, .mov or .mkv
--quilt-out --rgbd-out clip.mp4 o.mp4 => --quilt-out and --rgbd-out exclude each other
--show --quilt-out clip.mp4 => --show and --quilt-out exclude each other
--show --resume clip.mp4 => --show and --resume exclude each other
--show --compat clip.mp4 => --show and --compat exclude each other
--profile quick clip.mp4 o.mp4 => --profile is "quick", expected live, balanced or best
--codec av1 clip.mp4 o.mp4 => --codec is "av1", expected h264, hevc, h264rgb, ffv1 or prores
--codec ffv1 --crf 3 clip.mp4 o.mkv => --crf does not apply to --codec ffv1; leave it out
--codec ffv1 --compat clip.mp4 o.mkv => --compat goes with --codec h264 or hevc, not with ffv1
--crf 99 clip.mp4 o.mp4 => --crf is "99", expected a number 0..51
--max-rate -1 clip.mp4 o.mp4 => --max-rate is "-1", expected a number 0..100000
--max-rate much clip.mp4 o.mp4 => --max-rate is "much"
--max-rate 0.5 clip.mp4 o.mp4 => --max-rate is 0.5, expected 0 or 1..100000
--max-rate 9 --codec hevc clip.mp4 o.mp4 => --max-rate goes with --codec h264 or h264rgb, not with hevc
--max-rate 9 --codec prores clip.mp4 o.mov => --max-rate does not apply to --codec prores
--max-rate 9 --crf 0 clip.mp4 o.mp4 => --max-rate goes with --crf 1 or more
--from 1:2:3:4 clip.mp4 o.mp4 => --from is "1:2:3:4", expected seconds
--from 2 --to 1 clip.mp4 o.mp4 => --to is 1, expected a time after --from
--preview 0 clip.mp4 o.mp4 => --preview is "0", expected more than 0
--input-options size clip.mp4 o.mp4 => --input-options has "size", expected name=value
--depth-every 0 clip.mp4 o.mp4 => --depth-every is "0", expected a number 1..1000
--depth-every 2 --depth depth.mp4 clip.mp4 o.mp4 => --depth-every says how often depth is estimated, but here it is given
--depth-range 0:9 clip.mp4 o.mp4 => --depth-range goes with --depth
--depth views --depth-range 4095 clip.mp4 o.mp4 => expected two numbers of 0..65535
--depth views --depth-range 5:5 clip.mp4 o.mp4 => expected two numbers of 0..65535
--depth views --depth-range 9:1 clip.mp4 o.mp4 => expected two numbers of 0..65535
--depth views --depth-range 0:70000 clip.mp4 o.mp4 => expected two numbers of 0..65535
--depth views --depth-range a:b clip.mp4 o.mp4 => expected two numbers of 0..65535
--depth views --depth-range -1:5 clip.mp4 o.mp4 => expected two numbers of 0..65535
--depth views --depth-range 0:9x clip.mp4 o.mp4 => expected two numbers of 0..65535
--network-size 5000 clip.mp4 o.mp4 => --network-size is "5000", expected a number 16..4096
--depth-curve 3 clip.mp4 o.mp4 => 0.5..2
--from-quilt -k clip.mp4 o.mp4 => --from-quilt and -k exclude each other
--stereo-layout tb clip.mp4 o.mp4 => describes --stereo-out
--stereo-out e.mp4 --stereo-layout files clip.mp4 => --stereo-layout is "files", expected sbs
--stereo-out e.mp4 --quilt-out clip.mp4 => --stereo-out and --quilt-out exclude each other
--stereo-out e.mp4 --fit contain clip.mp4 => --fit chooses a part for a panel, but eyes see whole frames
--stereo-out e.png clip.mp4 => e.png
--stereo files clip.mp4 o.mp4 => files are for photos
--stereo left-right --rgbd right clip.mp4 o.mp4 => --stereo and --rgbd exclude each other
--resume clip.mp4 - => --resume continues a file, but standard output is written once
--plan p clip.mp4 - => --plan joins chunks, but standard output is written once
--progress json clip.mp4 - => --progress writes to standard output
in - => - stands for one video
--depth depth.mp4 in out => --depth applies to one video, expected a single video instead of a folder
)",
        [](const Arguments& call) { video(call); });
}

TEST_F(Jobs, OptionsOfVideosBecomeFields) {
    using Job = const VideoJob&;
    const auto isUsual = [](Job j) {
        return j.scene.recipe.views.method == ViewMethod::Layered && j.depthOptions.every == 0 &&
               j.encoding.crf == 16 && j.profile.bitsPerPixel == 50;
    };
    const std::pair<const char*, std::function<bool(Job)>> cases[] = {
        {"clip.mp4 o.mp4", isUsual},
        {"--profile balanced clip.mp4 o.mp4", isUsual},
        {"--profile live clip.mp4 o.mp4",
         [](Job j) {
             return j.scene.recipe.views.method == ViewMethod::Fast && j.encoding.crf == 20 &&
                    j.encoding.preset == EncoderPreset::UltraFast && j.profile.bitsPerPixel == 0;
         }},
        {"--show clip.mp4", [](Job j) { return j.profile.name == "live" && j.show; }},
        {"--profile best clip.mp4 o.mp4",
         [](Job j) {
             return j.scene.recipe.detail == Detail::Panel && j.depthOptions.every == 1 &&
                    j.encoding.preset == EncoderPreset::Medium;
         }},
        {"--profile best --depth-every 4 --crf 9 clip.mp4 o.mp4",
         [](Job j) { return j.depthOptions.every == 4 && j.encoding.crf == 9; }},
        {"--depth-every auto clip.mp4 o.mp4", [](Job j) { return j.depthOptions.every == 0; }},
        {"--depth depth.mp4 --depth-range 0:4095 clip.mp4 o.mp4",
         [](Job j) {
             return j.depthInput == "depth.mp4" && j.depth.fromFiles && j.depthRange->high == 4095;
         }},
        {"--depthmode clip.mp4 depth.mp4 o.mp4",
         [](Job j) { return j.depthInput == "depth.mp4" && j.input == "clip.mp4"; }},
        {"--large clip.mp4 o.mp4", [](Job j) { return j.depth.isLarge; }},
        {"--network x.onnx --network-size 32 clip.mp4 o.mp4",
         [](Job j) { return j.depth.network == "x.onnx" && j.depth.networkSize == 32; }},
        {"--geometric clip.mp4 o.mp4",
         [](Job j) { return j.scene.recipe.views.method == ViewMethod::Real; }},
        {"--keep clip.mp4 o.mp4", [](Job j) { return j.scene.recipe.detail == Detail::Panel; }},
        {"--map a.map clip.mp4 o.mp4", [](Job j) { return j.display.map == "a.map"; }},
        {"--method fast --refine 3 clip.mp4 o.mp4",
         [](Job j) { return j.scene.recipe.views.refinement == 3; }},
        {"-g --inpaint-from behind clip.mp4 o.mp4",
         [](Job j) { return j.scene.recipe.views.real.backgroundOnly; }},
        {"--fill continue clip.mp4 o.mp4",
         [](Job j) { return j.scene.recipe.views.layered.fill == LayeredFill::Continue; }},
        {"--fit contain clip.mp4 o.mp4", [](Job j) { return j.fit == FitMode::Contain; }},
        {"--continuous clip.mp4 o.mp4",
         [](Job j) { return j.scene.recipe.positions == ViewPositions::Continuous; }},
        {"--view-filter linear --sampling linear clip.mp4 o.mp4",
         [](Job j) {
             return j.scene.recipe.sampling.views == ViewFilter::Linear &&
                    j.scene.recipe.sampling.inTile == TileSampling::Linear;
         }},
        {"-c x.json --serial S-1 --invert off clip.mp4 o.mp4",
         [](Job j) {
             return j.display.calibration == "x.json" && j.display.serial == "S-1" &&
                    j.display.invert == InvertViews::Off;
         }},
        {"--from 1:30 --preview 0.5 clip.mp4 o.mp4",
         [](Job j) { return j.part.from == 90 && j.part.to == 90.5; }},
        {"--from 0:01:30.5 --to 2:00 clip.mp4 o.mp4",
         [](Job j) { return j.part.from == 90.5 && j.part.to == 120; }},
        {"--input-format v4l2 --input-options a=1,b=2 clip.mp4 o.mp4",
         [](Job j) { return j.part.format == "v4l2" && j.part.formatOptions.size() == 2; }},
        {"--max-rate 7 clip.mp4 o.mp4",
         [](Job j) { return j.isMaxRateGiven && j.encoding.maxRate == 7; }},
        {"--no-audio --no-subtitles --codec hevc --compat clip.mp4 o.mp4",
         [](Job j) {
             return !j.encoding.audio && !j.encoding.subtitles && j.encoding.compatible &&
                    j.encoding.codec == VideoCodec::Hevc;
         }},
        {"--quilt-out clip.mp4 o.mp4", [](Job j) { return j.product == VideoProduct::Quilt; }},
        {"--stereo-out e.mp4 clip.mp4 o.mp4",
         [](Job j) {
             return j.product == VideoProduct::Stereo && j.output == "e.mp4" &&
                    j.native == "o.mp4" && j.keepsEyes;
         }},
        {"-y --resume --report r.json clip.mp4 o.mp4",
         [](Job j) { return j.replace && j.resume && j.settings.empty(); }},
        {"--focus 0.3 clip.mp4 o.mp4",
         [](Job j) {
             return j.scene.recipe.views.focus == 0.3 && j.settings.at("--focus") == "0.3" &&
                    j.canReadAgain;
         }},
        {"in out", [](Job j) { return j.isFolder; }}};
    for (const auto& [call, isSo] : cases)
        EXPECT_TRUE(isSo(video(call))) << call;
}

TEST(Words, FormatsThatLoseAreWarnedOf) {
    using Warn = void (*)(const fs::path&, Messages&);
    const auto warning = [](Warn warn, const char* name) {
        Messages messages("test", false);
        warn(name, messages);
        return messages.warnings().empty() ? std::string() : messages.warnings().front();
    };
    for (const char* name : {"d.png", "d.tif", "d.TIFF", "d.pgm"})
        EXPECT_EQ(warning(warnAboutDepthFormat, name), "");
    for (const std::string name : {"d.jpg", "d.JPEG", "d.jp2"})
        EXPECT_TRUE(holds(warning(warnAboutDepthFormat, name.c_str()),
                          name + ": this format changes depth"));
    for (const std::string name : {"d.bmp", "d.webp"})
        EXPECT_TRUE(holds(warning(warnAboutDepthFormat, name.c_str()),
                          name + ": this format keeps 8 of the depth's"));
    for (const std::string name : {"b.jpg", "b.JPEG"})
        EXPECT_TRUE(
            holds(warning(warnAboutNativeFormat, name.c_str()), name + ": this format mixes"));
    for (const char* name : {"b.png", "b.tif", "b.bmp", "b.ppm"})
        EXPECT_EQ(warning(warnAboutNativeFormat, name), "");
    for (const char* name : {"a.gif", "a", ".png", "a.png.", "a.pgm"})
        EXPECT_THROW(requirePictureName(name), UsageError) << name;
    for (const char* name : {"a.png", "a.TIF", "a.jpg"})
        EXPECT_NO_THROW(requirePictureName(name)) << name;
}

TEST(Words, ShapesOfPicturesAndViewsAreSaid) {
    EXPECT_EQ(cutText(16.0 / 9, 0.75, FitMode::Cover), "58 % of the width is cut off");
    EXPECT_EQ(cutText(0.25, 0.75, FitMode::Cover), "67 % of the height is cut off");
    EXPECT_EQ(cutText(1 / 0.9, 0.75, FitMode::Cover), ""); // 32.5 %
    EXPECT_EQ(cutText(16.0 / 9, 0.75, FitMode::Contain), "");
    const auto said = [](cv::Size tile, double aspect) {
        const std::string text = quiltText({3, 2, tile, 6}, aspect);
        return text.substr(text.find("each view"));
    };
    EXPECT_EQ(said({40, 40}, 128.0 / 72), "each view 40 x 40 px, shown 16:9");
    EXPECT_EQ(said({40, 40}, 72.0 / 128), "each view 40 x 40 px, shown 9:16");
    EXPECT_EQ(said({40, 40}, 101.0 / 64), "each view 40 x 40 px, shown 1.58:1");
    EXPECT_EQ(said({30, 40}, 0.75), "each view 30 x 40 px");
}

} // namespace altiro3D::test
