#include "viewer/model/exports.hpp"

#include "altiro3D/error.hpp"
#include "cli/folders.hpp"
#include "cli/run_tool.hpp"

#include <algorithm>
#include <set>
#include <utility>

namespace altiro3D::viewer {

namespace fs = std::filesystem;

namespace {

bool isOneOf(const std::vector<BatchItem>& items, const fs::path& file) {
    return std::any_of(items.begin(), items.end(), [&file](const BatchItem& item) {
        std::error_code error;
        return fs::equivalent(item.source.file, file, error) ||
               (!item.source.depth.empty() && fs::equivalent(item.source.depth, file, error));
    });
}

// Calls a function. @return its problem, a sentence; empty: none
template <class Function>
QString problemOf(const Function& function) {
    try {
        function();
    } catch (const std::exception& error) {
        return QString::fromStdString(tools::sentenceOf(error));
    }
    return {};
}

// The setup for one file of many, made from the file as Exports::setup() is for the open picture.
Setup setupOf(const BatchItem& item, const std::shared_ptr<const Display>& display,
              const DepthMaker& depthMaker, Studio& studio) {
    const std::string name = item.source.file.string();
    if (isVideoName(item.source.file))
        throw Error(ErrorCode::Unsupported, name,
                    "is a video, expected a photo; \"Export video\" converts videos");
    const auto document = std::make_shared<const Document>(readDocument(item.source, *display));
    if (document->kind == Kind::Native)
        throw Error(ErrorCode::Unsupported, name,
                    "is a Native, which is finished, expected a photo or a quilt");
    const auto painted =
        item.painted.find(depthMaker.choose(item.knobs.depth, document->hasDepth()));
    return studio.prepare({document, item.knobs, display,
                           painted != item.painted.end() ? painted->second : PaintedDepth()});
}

// Exports the Natives one after the other, each with the bytes of a single export. A file that
// cannot be exported is reported and the others follow; videos and finished Natives are reported.
// @param progress receives 0..1; returns false to cancel. What is written then stays.
BatchReport exportBatch(const std::vector<BatchItem>& items,
                        const std::shared_ptr<const Display>& display,
                        const std::shared_ptr<DepthMaker>& depthMaker, const Progress& progress) {
    BatchReport report;
    Studio studio(depthMaker);
    for (std::size_t i = 0; i < items.size(); ++i) {
        const auto tell = [&](double done) {
            return progress((static_cast<double>(i) + done) / static_cast<double>(items.size()));
        };
        report.cancelled = !tell(0);
        if (report.cancelled) break;
        try {
            if (isOneOf(items, items[i].native))
                throw Error(ErrorCode::WriteFailed, items[i].native.string(),
                            "is one of the photos, expected another folder");
            const Setup setup = setupOf(items[i], display, *depthMaker, studio);
            report.cancelled = writeProduct(setup, Product::Native, items[i].native, tell).empty();
            if (report.cancelled) break;
            ++report.written;
        } catch (const std::exception& error) {
            report.problems.push_back(tools::sentenceOf(error));
        }
    }
    if (!report.cancelled && !items.empty()) progress(1);
    return report;
}

} // namespace

std::vector<fs::path> nativesOf(const std::vector<Source>& sources, const fs::path& folder) {
    std::vector<tools::FolderFile> files;
    for (const Source& source : sources) {
        fs::path file = source.file;
        if (!file.has_filename()) file = file.parent_path(); // "views/"
        files.push_back({file});
    }
    std::vector<fs::path> natives;
    std::set<std::string> taken;
    for (const std::string& stem : tools::outputStems(files)) {
        std::string name = stem;
        for (int number = 2; !taken.insert(name).second; ++number)
            name = stem + "-" + std::to_string(number);
        natives.push_back(folder / (name + "_native.png"));
    }
    return natives;
}

Exports::Exports(Files& files, Settings& settings, Stage& stage)
    : files_(files), settings_(settings), stage_(stage) {}

Exports::~Exports() {
    cancelling_ = true;
}

QString Exports::obstacle() const {
    if (running_) return tr("Another export is under way; export again when it is done");
    if (!files_.document()) return tr("Nothing is open that could be exported");
    if (!stage_.isShown())
        return tr("The file is still being opened; export again when its picture is shown");
    if (stage_.frame().knobs.depth != settings_.knobs().depth)
        return tr("The depth is still being estimated; export again when the picture shows it");
    if (stage_.frame().setup.painted.revision != stage_.painted().revision)
        return tr("The depth is still being changed; export again when the picture shows it");
    return {};
}

Setup Exports::setup() const {
    Setup setup = stage_.frame().setup;
    setup.knobs = settings_.knobs();
    setup.isDraft = false;
    setup.eyes = stage_.eyes();
    return setup;
}

void Exports::run(std::function<std::function<void()>()> work) {
    running_ = true;
    cancelling_ = false;
    worker_.post(0, [this, work = std::move(work)] {
        later(this, [this, end = work()] {
            running_ = false;
            end();
        });
    });
}

Progress Exports::teller() {
    return [this](double done) {
        later(this, [this, done] { emit progress(done); });
        return !cancelling_;
    };
}

bool Exports::start(Product product, const fs::path& target) {
    if (!obstacle().isEmpty()) return false;
    run([this, setup = setup(), product, target] {
        QString file;
        const QString problem = problemOf(
            [&] { file = QString::fromStdString(writeProduct(setup, product, target, teller())); });
        return [this, file, problem, product, revision = setup.painted.revision] {
            if (product == Product::Depth && !file.isEmpty()) stage_.setSaved(revision);
            emit ended(file, problem);
        };
    });
    return true;
}

Knobs Exports::videoKnobs() const {
    Knobs knobs = settings_.knobs();
    knobs.depth = files_.depthMaker()->choose(knobs.depth, files_.document()->hasDepth());
    return knobs;
}

QString Exports::videoObstacle() const {
    if (running_) return tr("Another export is under way; export again when it is done");
    if (files_.isReading() || !files_.document() || !files_.document()->video)
        return tr("Open a video first");
    return QString::fromStdString(videoExportObstacle(*files_.document(), videoKnobs()));
}

bool Exports::startVideo(const fs::path& file, bool goesOn) {
    if (!videoObstacle().isEmpty()) return false;
    files_.setPlaying(false);
    const Document& document = *files_.document();
    const Knobs knobs = videoKnobs();
    Display display = *files_.display();
    if (document.kind == Kind::Scene) display.quilt = layoutOf(knobs, display);
    run([this, job = videoJobOf(document, knobs, display, file, goesOn), display] {
        VideoExportResult result;
        const QString problem = problemOf([&] {
            result = exportVideo(job, display, [this](const VideoExportState& state) {
                later(this, [this, state] { emit videoProgress(state); });
                return !cancelling_;
            });
        });
        return [this, result, problem] { emit videoEnded(result, problem); };
    });
    return true;
}

std::vector<BatchItem> Exports::batch(const fs::path& folder) const {
    const std::vector<Source>& sources = files_.sources();
    const std::vector<fs::path> natives = nativesOf(sources, folder);
    std::vector<BatchItem> items;
    for (std::size_t i = 0; i < sources.size(); ++i)
        items.push_back({sources[i], settings_.knobsOf(sources[i].file), natives[i],
                         stage_.painted(sources[i])});
    return items;
}

bool Exports::startAll(const fs::path& folder) {
    if (running_ || files_.sources().empty()) return false;
    run([this, items = batch(folder), display = files_.display(), maker = files_.depthMaker()] {
        const BatchReport report = exportBatch(items, display, maker, teller());
        return [this, report] { emit allEnded(report); };
    });
    return true;
}

} // namespace altiro3D::viewer
