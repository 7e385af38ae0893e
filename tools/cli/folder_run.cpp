#include "cli/folder_run.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/video_io.hpp"

#include <new>
#include <opencv2/core.hpp>
#include <system_error>
#include <utility>

namespace altiro3D::tools {

namespace fs = std::filesystem;

namespace {

bool isFailureOfMachine(const std::exception& error) {
    if (const auto* ours = dynamic_cast<const Error*>(&error)) {
        return ours->code() == ErrorCode::WriteFailed || ours->code() == ErrorCode::OutOfMemory ||
               ours->code() == ErrorCode::NetworkFailed;
    }
    if (const auto* fromOpenCv = dynamic_cast<const cv::Exception*>(&error))
        return fromOpenCv->code == cv::Error::StsNoMem;
    return dynamic_cast<const std::bad_alloc*>(&error) != nullptr ||
           dynamic_cast<const std::system_error*>(&error) != nullptr;
}

} // namespace

void addRecursiveOption(CommandLine& commandLine, const std::string& things) {
    commandLine.addAdvanced({"recursive"},
                            "Also convert the " + things + " in the subfolders of DIR.");
}

std::vector<FolderFile> listFiles(const fs::path& folder, const FolderSearch& search,
                                  std::vector<LeftOutFile>& leftOut, Messages& messages) {
    FolderContents found = searchFolder(folder, search);
    for (const LeftOutFile& file : found.leftOut) {
        const std::string line = file.file.string() + ": " + file.why;
        if (file.kind == FileKind::Native) { // from an earlier run, or a mistake
            messages.warn(line);
        } else {
            messages.say(line);
        }
        leftOut.push_back(file);
    }
    return std::move(found.files);
}

void requireDirectoryName(const fs::path& name, const std::string& things,
                          const std::string& remedy) {
    std::error_code error;
    if (fs::is_directory(name, error)) return;
    if (!fs::exists(name, error) && !canWriteImage(name) && !canWriteVideo(name)) return;
    throw UsageError(name.string() +
                     ": names one file, expected a directory for the outputs of several " + things +
                     remedy);
}

bool isFileWithContents(const fs::path& file) {
    std::error_code error;
    return fs::is_regular_file(file, error) && fs::file_size(file, error) > 0 && !error;
}

FolderRun::FolderRun(std::string thing, std::size_t files, std::vector<LeftOutFile> leftOut,
                     Messages& messages)
    : thing_(std::move(thing)), messages_(messages), leftOut_(std::move(leftOut)), files_(files),
      progress_(files) {
    messages.flushWarnings(); // these belong to no file
}

FolderRun::Outcome FolderRun::convert(const fs::path& file, const std::function<int()>& work) {
    Outcome outcome;
    ++begun_;
    messages_.setSubject(file.filename().string());
    progress_.step(file.filename().string());
    try {
        outcome.status = work();
        ++(outcome.status == kExitDone      ? made_
           : outcome.status == kExitStopped ? stopped_
                                            : failed_);
        messages_.flushWarnings();
    } catch (const NotTaken& other) {
        messages_.dropWarnings();
        messages_.say(other.file.why);
        leftOut_.push_back(other.file);
        outcome.leftOut = other.file.why;
    } catch (const std::exception& error) {
        outcome.status = kExitFailed;
        outcome.error = sentenceOf(error);
        messages_.dropWarnings();
        messages_.fail(outcome.error);
        ++failed_;
        mayRecover_ = mayRecover_ || isFailureOfMachine(error);
    }
    messages_.setSubject({});
    return outcome;
}

void FolderRun::skip(const fs::path& file, const fs::path& output) {
    messages_.detail(file.filename().string() + ": skipped, as " + output.string() + " exists");
    ++skipped_;
}

std::string FolderRun::place() const {
    return "[" + std::to_string(begun_) + "/" + std::to_string(files_) + "]";
}

int FolderRun::end() {
    progress_.clear();
    std::string text = counted(made_, thing_) + " made";
    if (skipped_ > 0) text += ", " + std::to_string(skipped_) + " skipped as the outputs exist";
    if (stopped_ > 0) text += ", " + std::to_string(stopped_) + " stopped";
    if (begun_ < files_) text += ", " + std::to_string(files_ - begun_) + " not begun";
    if (failed_ > 0) text += ", " + std::to_string(failed_) + " failed";
    if (!leftOut_.empty())
        text += ", " + std::to_string(leftOut_.size()) + " left out (" + kindsText(leftOut_) + ")";
    const std::chrono::duration<double> spent = std::chrono::steady_clock::now() - start_;
    messages_.say(text + ", in " + fixed(spent.count(), spent.count() < 10 ? 1 : 0) + " s");
    if (stopped_ > 0) return kExitStopped;
    return failed_ == 0 ? kExitDone : kExitFailed;
}

} // namespace altiro3D::tools
