#include "media/resumable_video.hpp"

#include "altiro3D/error.hpp"
#include "media/ffmpeg.hpp"
#include "support/files.hpp"
#include "support/slow.hpp"
#include "support/video.hpp"

#include <gtest/gtest.h>
#include <opencv2/core.hpp>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;

constexpr int kSegmentFrames = 10;

VideoWriterOptions optionsFor(const VideoFacts& facts) {
    VideoWriterOptions options;
    options.size = facts.size;
    // With frames out of order. From veryfast on x264 reads memory it has not set
    // (docs/reliability.md).
    options.preset = EncoderPreset::SuperFast;
    options.crf = 4;
    options.timeBase = facts.timeBase;
    options.frameRate = facts.averageRate;
    options.constantRate = facts.constantRate;
    options.threads = 1;
    return options;
}

ResumableVideoOptions resumable(bool resume = false, const RunSettings& settings = {}) {
    ResumableVideoOptions options;
    options.segmentFrames = kSegmentFrames;
    options.resume = resume;
    options.settings = settings;
    return options;
}

// Copies a clip; stops after a number of frames without finishing, as a killed process does. The
// state holds the number of frames before it, like a caller's state.
bool copyClip(const fs::path& from, const fs::path& to, bool resume, std::int64_t most = 1 << 30) {
    VideoReader reader(from);
    VideoReader probe(from);
    ResumableVideoWriter writer(to, optionsFor(reader.facts()), resumable(resume), &probe);
    std::int64_t number = writer.kept().frames;
    EXPECT_EQ(writer.kept().state.bytes, number == 0 ? "" : std::to_string(number));
    if (number > 0) reader.skipTo(writer.kept().nextPts);
    for (VideoFrame frame; reader.read(frame); ++number) {
        if (--most < 0) return false;
        writer.write(frame, {writer.endsSegment(number) ? std::to_string(number + 1) : ""});
    }
    VideoReader again(from);
    writer.finish(&again);
    EXPECT_FALSE(writer.keepsWork());
    return true;
}

std::string streamHash(const fs::path& file, const std::string& stream) {
    return ffmpeg("-i " + arg(file) + " -map 0:" + stream + " -c copy -f md5 -");
}

std::string times(const fs::path& file) {
    std::string text;
    for (const std::string& one : lines(ffprobe(file, "frame=pts_time", "-select_streams v:0")))
        text += one.substr(0, one.find('|')) + "\n";
    return text;
}

class ResumableVideo : public FfmpegTest {
  protected:
    // A clip with moving pictures, two tracks of sound, and chapters.
    fs::path makeClip(const std::string& timing = "") const {
        spill(directory / "chapters.txt",
              ";FFMETADATA1\ntitle=A clip\n[CHAPTER]\nTIMEBASE=1/1000\nSTART=0\nEND=700\n"
              "title=One\n[CHAPTER]\nTIMEBASE=1/1000\nSTART=700\nEND=1800\ntitle=Two\n");
        return make("clip.mp4", "-f lavfi -i testsrc2=size=96x64:rate=25:duration=1.8 -f lavfi -i "
                                "sine=440:duration=1.8 -f lavfi -i sine=880:duration=1.8 -i " +
                                    arg(directory / "chapters.txt") +
                                    " -map 0 -map 1 -map 2 -map_metadata 3 -map_chapters 3 " +
                                    timing + " -c:v libx264 -bf 2 -g 12 -pix_fmt yuv444p -c:a aac");
    }

    // The clip, copied in one run.
    fs::path makeWhole(const fs::path& clip) const {
        EXPECT_TRUE(copyClip(clip, directory / "whole.mp4", false));
        return directory / "whole.mp4";
    }
};

TEST_F(ResumableVideo, TimesSoundAndChaptersAreTheSources) {
    ALTIRO3D_TAKES(4);
    const auto sideOf = [](const fs::path& file) { // all but the pictures
        return streamHash(file, "a:0") + streamHash(file, "a:1") +
               ffprobe(file, "chapter=start_time:chapter_tags=title");
    };
    for (const char* timing :
         {"", "-vf setpts=N*N*0.001/TB -fps_mode vfr -enc_time_base 1/90000"}) {
        const fs::path clip = makeClip(timing);
        const std::vector<VideoFrame> before = allFrames(clip);
        const std::string timesBefore = times(clip);
        const std::string sideBefore = sideOf(clip);
        for (const char* name : {"out.mp4", "out.mov", "out.mkv"}) {
            const fs::path out = directory / name;
            ASSERT_TRUE(copyClip(clip, out, false));
            EXPECT_FALSE(fs::exists(unfinishedVideoDirectory(out)));
            if (out.extension() != ".mkv") {
                EXPECT_EQ(times(out), timesBefore);
            }
            EXPECT_EQ(sideOf(out), sideBefore);
            const std::vector<VideoFrame> after = allFrames(out);
            ASSERT_EQ(after.size(), before.size());
            for (std::size_t i = 0; i < after.size(); ++i)
                EXPECT_GT(cv::PSNR(after[i].picture, before[i].picture), 32) << i;
        }
    }
}

TEST_F(ResumableVideo, ARunInterruptedAnywhereContinuesToTheSameBytes) {
    const fs::path clip = makeClip();
    const fs::path whole = makeWhole(clip);
    const fs::path out = directory / "out.mp4";
    for (const std::int64_t first : {0, 1, 9, 10, 11, 25}) {
        ASSERT_FALSE(copyClip(clip, out, false, first));
        EXPECT_FALSE(fs::exists(out));
        ASSERT_FALSE(copyClip(clip, out, true, 7)); // and once more
        ASSERT_FALSE(copyClip(clip, out, true, 0));
        ASSERT_TRUE(copyClip(clip, out, true));
        EXPECT_TRUE(slurp(out) == slurp(whole)) << first;
        EXPECT_FALSE(fs::exists(unfinishedVideoDirectory(out)));
        fs::remove(out);
    }
}

TEST_F(ResumableVideo, ARunEndedEarlyLeavesAWholeFileAndCanContinue) {
    const fs::path clip = makeClip();
    const fs::path whole = makeWhole(clip);
    const fs::path out = directory / "out.mp4";
    {
        VideoReader reader(clip);
        ResumableVideoWriter writer(out, optionsFor(reader.facts()), resumable());
        VideoFrame frame;
        for (std::int64_t i = 0; i < 23; ++i) {
            ASSERT_TRUE(reader.read(frame));
            EXPECT_EQ(writer.keepsWork(), i >= resumable().segmentFrames) << i;
            writer.write(frame, {writer.endsSegment(i) ? std::to_string(i + 1) : ""});
        }
        VideoReader again(clip);
        writer.finish(&again, false);
        EXPECT_TRUE(writer.keepsWork());
    }
    EXPECT_EQ(lines(ffprobe(out, "packet=pts", "-select_streams v:0")).size(), 23u);
    const double sound = std::stod(ffprobe(out, "stream=duration", "-select_streams a:0"));
    EXPECT_NEAR(sound, 23.0 / 25, 0.05);
    ffmpeg("-xerror -i " + arg(out) + " -f null -");
    ASSERT_TRUE(copyClip(clip, out, true));
    EXPECT_TRUE(slurp(out) == slurp(whole));
    // the sound keeps step in whatever unit the times are: 1/25 s instead of 1/12800 s
    VideoReader reader(clip);
    VideoWriterOptions options = optionsFor(reader.facts());
    options.timeBase = {1, 25};
    ResumableVideoWriter writer(directory / "other.mp4", options, resumable());
    VideoFrame frame;
    for (std::int64_t i = 0; i < 24 && reader.read(frame); ++i)
        if (i % 4 == 0) writer.write({frame.picture, i, 4});
    VideoReader again(clip);
    writer.finish(&again, false);
    EXPECT_NEAR(
        std::stod(ffprobe(directory / "other.mp4", "stream=duration", "-select_streams a:0")),
        24.0 / 25, 0.05);
}

TEST_F(ResumableVideo, APartOfAVideoIsJoinedWithItsPartOfTheSound) {
    const fs::path clip = makeClip();
    VideoReaderOptions part;
    part.from = 0.4;
    part.to = 1.4;
    VideoReader reader(clip, part);
    VideoReader plainSource(clip, part);
    VideoWriterOptions options = optionsFor(reader.facts());
    const fs::path out = directory / "out.mp4";
    const fs::path plain = directory / "plain.mp4";
    ResumableVideoWriter writer(out, options, resumable());
    VideoWriter plainWriter(plain, options, &plainSource);
    for (VideoFrame frame; reader.read(frame);)
        writer.write(frame);
    for (VideoFrame frame; plainSource.read(frame);)
        plainWriter.write(frame);
    VideoReader again(clip, part);
    writer.finish(&again);
    plainWriter.finish();
    EXPECT_EQ(times(out), times(plain));
    EXPECT_EQ(streamHash(out, "a:0"), streamHash(plain, "a:0"));
    EXPECT_EQ(streamHash(out, "a:1"), streamHash(plain, "a:1"));
    EXPECT_EQ(ffprobe(out, "chapter=start_time,end_time"),
              ffprobe(plain, "chapter=start_time,end_time"));
}

void writeFrames(ResumableVideoWriter& writer, int from, int to) {
    for (int i = from; i < to; ++i)
        writer.write({movingPicture({64, 48}, i), i, 1}, {"state"});
}

class ResumableVideoFiles : public FileTest {};

TEST_F(ResumableVideoFiles, AnUnfinishedRunIsNeitherLostNorMixedUp) {
    const fs::path out = directory / "out.mp4";
    {
        ResumableVideoWriter writer(out, smallOptions(), resumable(false, {{"--crf", "18"}}));
        writeFrames(writer, 0, 15);
    }
    const auto begin = [&](bool resume, const RunSettings& settings) {
        return problemOf(out, [&] {
            const ResumableVideoWriter writer(out, smallOptions(), resumable(resume, settings));
        });
    };
    EXPECT_EQ(begin(false, {{"--crf", "18"}}),
              "an unfinished run of it is kept in " + out.string() +
                  ".parts, expected it to be resumed or discarded");
    EXPECT_TRUE(isVideoUnfinished(out));
    EXPECT_EQ(begin(true, {{"--crf", "20"}}),
              "was begun with other settings (--crf was 18 and is 20), expected the same");
    EXPECT_EQ(begin(true, {{"--crf", "18"}, {"-k", ""}}),
              "was begun with other settings (-k was not set and is set), expected the same");
    {
        ResumableVideoWriter writer(out, smallOptions(), resumable(true, {{"--crf", "18"}}));
        EXPECT_EQ(writer.kept().frames, 10);
        EXPECT_EQ(writer.kept().nextPts, 10);
        EXPECT_EQ(writer.kept().state.bytes, "state");
        EXPECT_TRUE(holds(begin(true, {{"--crf", "18"}}), "in use by another process"));
        EXPECT_TRUE(holds(errorOf([&] { writeFrames(writer, 9, 10); }), "expected 10 or more"));
    }
    discardUnfinishedVideo(out);
    EXPECT_FALSE(isVideoUnfinished(out));
    EXPECT_FALSE(fs::exists(unfinishedVideoDirectory(out)));
    discardUnfinishedVideo(out); // nothing is there: nothing to do
}

TEST_F(ResumableVideoFiles, ARunThatHasKeptNothingLeavesNothing) {
    const fs::path out = directory / "out.mkv";
    const VideoFrame frame{cv::Mat(48, 64, CV_8UC3, cv::Scalar(1, 2, 3)), 0, 1};
    { ResumableVideoWriter(out, smallOptions(), resumable()).write(frame); }
    EXPECT_TRUE(fs::is_empty(directory.path()));
    const fs::path parts = unfinishedVideoDirectory(out);
    fs::create_directory(parts);
    spill(parts / "mine.txt", "mine");
    { ResumableVideoWriter(out, smallOptions(), resumable()).write(frame); }
    EXPECT_EQ(slurp(parts / "mine.txt"), "mine");
    EXPECT_FALSE(fs::exists(parts / "run.json"));
    // ended before a segment is whole, and so that it cannot be joined
    const fs::path brief = directory / "brief.mkv";
    const fs::path never = directory / "never.mkv";
    for (const fs::path& file : {brief, never}) {
        ResumableVideoWriter writer(file, smallOptions(), resumable());
        writer.write(frame);
        if (file == never) {
            fs::create_directory(never);
            EXPECT_THROW(writer.finish(nullptr, false), Error);
        } else {
            writer.finish(nullptr, false);
        }
        EXPECT_FALSE(writer.keepsWork());
    }
    EXPECT_TRUE(fs::is_regular_file(brief));
    for (const fs::path& file : {brief, never})
        EXPECT_FALSE(fs::exists(unfinishedVideoDirectory(file))) << file;
}

TEST_F(ResumableVideoFiles, DamagedLeftoversAreRefusedByName) {
    const fs::path out = directory / "out.mp4";
    const fs::path parts = unfinishedVideoDirectory(out);
    {
        ResumableVideoWriter writer(out, smallOptions(), resumable());
        writeFrames(writer, 0, 20);
    }
    const auto resume = [&] {
        return errorOf(
            [&] { const ResumableVideoWriter writer(out, smallOptions(), resumable(true)); });
    };
    const std::string run = slurp(parts / "run.json");
    for (const std::string& broken :
         {std::string(), std::string("{"), std::string("[]"), std::string("{\"format\": 3}"),
          run.substr(0, run.size() / 2)}) {
        spill(parts / "run.json", broken);
        EXPECT_TRUE(holds(resume(), "run.json: is")) << broken << resume();
    }
    const auto with = [&](const std::string& part, const std::string& other) {
        std::string changed = run;
        changed.replace(changed.find(part), part.size(), other);
        return changed;
    };
    const std::string deep = std::string(100000, '[') + std::string(100000, ']');
    for (const std::string& forged :
         {with("\"frames\": ", "\"frames\": 922337203685477"),
          with("\"end\": ", "\"end\": 922337203685477580"),
          with("\"pts\": ", "\"pts\": -1, \"x\": "), with("\"pts\": ", "\"pts\": 1e300, \"x\": "),
          with("\"reorderedPlaces\": ", "\"reorderedPlaces\": 2000"),
          with("\"reorderedPlaces\": ", "\"reorderedPlaces\": -1, \"x\": "),
          with("\"settings\": {", "\"settings\": {\"a\": " + deep + ", ")}) {
        spill(parts / "run.json", forged);
        EXPECT_TRUE(holds(resume(), "run.json: "));
    }
    // Names that lead elsewhere: nothing there is read or removed.
    const fs::path outside = directory / "outside.txt";
    spill(outside, "mine");
    for (const std::string& name : {outside.generic_string(), std::string("../outside.txt")}) {
        spill(parts / "run.json", with("\"000002.state\"", "\"" + name + "\""));
        const std::string error = errorOf([&] {
            ResumableVideoWriter writer(out, smallOptions(), resumable(true));
            writeFrames(writer, 20, 30); // the state before is of no use any more
        });
        EXPECT_EQ(error, (parts / "run.json").string() + ": lists \"" + name +
                             "\" in place of 000002.state, expected an unfinished run");
        EXPECT_EQ(slurp(outside), "mine");
        spill(directory / "000001.mp4", slurp(parts / "000001.mp4"));
        const std::string led = name == outside ? (directory / "000001.mp4").generic_string()
                                                : std::string("../000001.mp4");
        spill(parts / "run.json", with("\"000001.mp4\"", "\"" + led + "\""));
        EXPECT_EQ(resume(), (parts / "run.json").string() + ": lists \"" + led +
                                "\" in place of 000001.mp4, expected an unfinished run");
    }
    spill(parts / "run.json", run);
    const std::string segment = slurp(parts / "000001.mp4");
    spill(parts / "000001.mp4", segment.substr(0, 100));
    EXPECT_TRUE(holds(resume(), "lists 000001.mp4, which is missing or damaged"));
    spill(parts / "000001.mp4", std::string(segment.size(), 'x')); // found when it is joined
    ResumableVideoWriter writer(out, smallOptions(), resumable(true));
    const std::string error = errorOf([&] { writer.finish(nullptr); });
    EXPECT_TRUE(holds(error, "000001.mp4: cannot be read"));
    EXPECT_FALSE(fs::exists(out));
    EXPECT_TRUE(fs::exists(parts / "000002.mp4"));
}

TEST_F(ResumableVideo, WhatTheFileCannotHoldIsSaidBeforeAnyWork) {
    VideoReader reader(make("clip.mkv", "-f lavfi -i testsrc2=size=64x48:rate=25:duration=0.4 -f "
                                        "lavfi -i sine=duration=0.4 -c:v libx264 -c:a wavpack"));
    const auto problem = [&](const VideoWriterOptions& encoding, int segmentFrames,
                             VideoReader* source = nullptr) {
        ResumableVideoOptions options = resumable();
        options.segmentFrames = segmentFrames;
        return errorOf(
            [&] { ResumableVideoWriter(directory / "out.mp4", encoding, options, source); });
    };
    const std::string error = problem(optionsFor(reader.facts()), kSegmentFrames, &reader);
    EXPECT_TRUE(holds(error, "cannot hold the sound wavpack"));
    EXPECT_TRUE(holds(error, ".mkv"));
    EXPECT_FALSE(fs::exists(directory / "out.mp4.parts"));
    VideoWriterOptions prores = smallOptions();
    prores.codec = VideoCodec::ProRes;
    EXPECT_TRUE(holds(problem(prores, kSegmentFrames), "cannot hold prores"));
    EXPECT_TRUE(holds(problem(smallOptions(), 0), "segmentFrames: is 0"));
    ResumableVideoWriter writer(directory / "o.mp4", smallOptions(), resumable());
    EXPECT_TRUE(holds(errorOf([&] { writer.finish(nullptr); }), "before the first frame"));
}

TEST_F(ResumableVideoFiles, EveryCodecIsJoined) {
    const std::pair<VideoCodec, const char*> cases[] = {
        {VideoCodec::H264Rgb, "a.mp4"}, {VideoCodec::Hevc, "b.mp4"},
        {VideoCodec::Hevc, "b.mkv"},    {VideoCodec::Ffv1, "c.mkv"},
        {VideoCodec::ProRes, "d.mov"},  {VideoCodec::ProRes, "d.mkv"}};
    for (const auto& [codec, name] : cases) {
        const bool isThere = avcodec_find_encoder_by_name("libx265") != nullptr; // not on Windows
        if (codec == VideoCodec::Hevc && !isThere) continue;
        VideoWriterOptions options = smallOptions();
        options.codec = codec;
        const fs::path out = directory / name;
        ResumableVideoWriter writer(out, options, resumable());
        writeFrames(writer, 0, 24);
        writer.finish(nullptr);
        const std::vector<VideoFrame> frames = allFrames(out);
        ASSERT_EQ(frames.size(), 24u) << name;
        const double unit = VideoReader(out).facts().timeBase.value();
        for (int i = 0; i < 24; ++i) {
            const VideoFrame& frame = frames[static_cast<std::size_t>(i)];
            EXPECT_NEAR(static_cast<double>(frame.pts) * unit, i / 25.0, 0.0011) << name;
            EXPECT_GT(cv::PSNR(frame.picture, movingPicture({64, 48}, i)), 30) << name << i;
        }
    }
}

} // namespace
} // namespace altiro3D::test
