// video2native: turns videos into Native videos.

#include "cli/json_text.hpp"
#include "video/video_run.hpp"

using namespace altiro3D;
using namespace altiro3D::tools;

namespace altiro3D::tools { // for the tests of videoJob()

void addVideoOptions(CommandLine& commandLine) {
    commandLine.addUsage("[options] IN OUT.mp4");
    commandLine.addUsage("[options] --rgbd right RGBD.mp4 OUT.mp4");
    commandLine.addUsage("[options] --depth DEPTH IN OUT.mp4");
    commandLine.addUsage("[options] --from-quilt QUILT_qs8x6a0.75.mp4 OUT.mp4");
    commandLine.addUsage("[options] DIR OUTDIR");
    commandLine.addUsage("--profile live /dev/video0 OUT.mkv");
    commandLine.addUsage("[options] --stereo-out FILE IN [OUT.mp4]");
    commandLine.addUsage("[options] --show IN");
    commandLine.addUsage("--plan PLAN [options] IN OUT.mp4");
    commandLine.addUsage("--chunk K PLAN");
    commandLine.addUsage("--join PLAN");
    commandLine.addSection("Profile");
    commandLine.add(
        {"profile"},
        "balanced (default): method layered, depth as often as the picture needs it, --preset "
        "superfast --crf 16; live: method fast, --preset ultrafast --crf 20; best: layered with "
        "-k --continuous, --depth-every 1, --preset medium --crf 12. Other options override it.",
        "live|balanced|best");
    addDepthOptions(commandLine, Medium::Video);
    commandLine.addAdvanced(
        {"depth-every"},
        "Run the network on every N-th frame and carry its depth along the motion in "
        "between; auto (default): as often as the pictures require; 1: on every frame.",
        "N");
    commandLine.addAdvanced(
        {"depth-range"},
        "Numbers of 16-bit depth (--depth) that become the two ends; default: the percentiles 0.5 "
        "and 99.5 of all its pictures. Needed for depth from a pipe.",
        "LOW:HIGH");
    commandLine.addSection("Views");
    addFields(commandLine, RecipePart::Views, AutoUse::Named);
    addNativeOptions(commandLine);
    addFields(commandLine, RecipePart::Placement, AutoUse::Named);
    commandLine.addSection("Input");
    commandLine.addAdvanced({"from-quilt"}, "The frames of IN are quilts.");
    commandLine.add({"from"}, "Begin at this time: seconds, or [h:]mm:ss.", "TIME");
    commandLine.add({"to"}, "End at this time.", "TIME");
    commandLine.add({"preview"}, "Make only the first SECONDS seconds.", "SECONDS");
    commandLine.addAdvanced({"input-format"},
                            "FFmpeg's name of the format or device of IN, if it is not detected "
                            "(v4l2, x11grab, lavfi).",
                            "NAME");
    commandLine.addAdvanced({"input-options"},
                            "Settings of that format, such as video_size=1280x720,framerate=30.",
                            "LIST");
    commandLine.addAdvanced({"no-deinterlace"}, "Leave interlaced frames as they are.");
    commandLine.addSection("Output");
    commandLine.add({"quilt-out"},
                    "Write a quilt video (named ..._qs<columns>x<rows>a<aspect>, 4:2:0) "
                    "for other players, not a Native.");
    commandLine.addAdvanced(
        {"rgbd-out"}, "Write frame and depth side by side (4:2:0), not a Native; squeezed to half "
                      "their width if the name of OUT says so (clip_HRGBD.mp4).");
    commandLine.add({"stereo-out"},
                    "Write a video for two eyes (headsets, 3D televisions, red-cyan glasses); "
                    "without OUT no Native is made.",
                    "FILE");
    addEyesOptions(commandLine, "stereo-out", false);
    addEncoderOptions(commandLine);
    commandLine.add({"show"},
                    "Show the video on the display with altiro3Dview and profile live; write "
                    "no file.");
    commandLine.addAdvanced({"screen"}, "Screen for --show, instead of the display's own.", "NAME");
    addBridgeOptions(commandLine, "With --quilt-out or --rgbd-out: also show the video by");
    commandLine.add({"resume"}, "Continue an interrupted run of the same command. In a folder, "
                                "skip videos whose output is complete.");
    commandLine.add({"y"}, "Replace outputs that exist, and start from the beginning.");
    addRecursiveOption(commandLine, "videos");
    addProgressOption(commandLine);
    commandLine.addAdvanced({"report"},
                            "Write settings, counts and the time of each stage, for programs.",
                            "FILE.json");
    addVideoChunkOptions(commandLine);
    addDisplayOptions(commandLine);
    addSamplingOptions(commandLine);
    commandLine.addNote("IN is anything that FFmpeg reads, - for standard input, or a capture "
                        "device. OUT may be - for standard output, to which Matroska is written; "
                        "messages then go to standard error, and the run cannot be resumed. After "
                        "Ctrl-C the video is complete up to that time. An interrupted run leaves "
                        "OUT.parts; the same command with --resume continues it.");
    commandLine.addNote(
        "In a directory, only videos are converted; one bad video does not stop the rest. Clips "
        "of Live Photos, videos of quilts and of depth, Native videos, pictures and other files "
        "are named, counted and left out.");
    commandLine.addNote(
        "A video of --stereo-out has the frames' own size and needs no display. It has 4:2:0; "
        "anaglyph and rows have 4:4:4, because 4:2:0 mixes their eyes (--compat: 4:2:0). The "
        "parallax between the eyes is --strength, by default 2.5. The pictures in a video of both "
        "eyes stay as filmed and only get this layout, unless --strength, --focus, --depth-curve, "
        "--method or --stereo-keep is given.");
    commandLine.addExample("clip.mp4 native.mp4",
                           "Make a Native video for the display that is connected.");
    commandLine.addExample("--profile live --preview 5 clip.mp4 look.mp4",
                           "Make the first 5 seconds quickly, as a preview.");
    commandLine.addExample("--stereo-out clip_LRF.mp4 clip.mp4",
                           "Make a side-by-side video for a headset or a 3D television.");
    commandLine.addExample("--depth clip-depth.mp4 clip.mp4 given.mp4",
                           "Take the depth from a video.");
}

} // namespace altiro3D::tools

int main(int argc, char** argv) {
    CommandLine commandLine("video2native",
                            "Turns a flat video into a Native video for a light-field display: "
                            "depth is estimated (or given) and kept steady, every sub-pixel of the "
                            "panel shows its own view; sound, subtitles and chapters are kept.");
    addVideoOptions(commandLine);
    return runTool(argc, argv, commandLine, [&](const CommandLine& given, Messages& messages) {
        if (const auto status =
                runVideoChunks(given, {argv, argv + argc}, addVideoOptions, messages))
            return *status;
        const VideoJob job = videoJob(given);
        return job.isFolder ? runVideoFolder(job, messages) : runVideo(job, messages);
    });
}
