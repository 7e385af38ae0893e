// run.json of an unfinished video; beside it lie a segment of two frames and a state.

#include "fuzz.hpp"
#include "video_samples.hpp"

using namespace altiro3D;

int LLVMFuzzerTestOneInput(const std::uint8_t* data, std::size_t size) {
    static const fuzz::Directory directory;
    static const std::filesystem::path video = directory.path() / "a.mkv";
    static const std::filesystem::path parts = unfinishedVideoDirectory(video);
    static const std::string segment = fuzz::beginRun(video).segment;
    directory.file("a.mkv.parts/000001.mkv", segment);
    directory.file("a.mkv.parts/000001.state", "the state");
    directory.file("a.mkv.parts/run.json", fuzz::textOf(data, size));
    fuzz::reads([&] {
        ResumableVideoWriter writer(video, fuzz::videoOptions(), fuzz::runOptions(true));
        const KeptVideo& kept = writer.kept();
        fuzz::require(kept.frames >= 0 && kept.nextPts >= 0, "what is kept is not less than none");
        writer.write({fuzz::samplePicture(1), kept.nextPts, 1});
        writer.finish(nullptr, false);
    });
    return 0;
}
