// Exports: one picture, or all open files.

#include "viewer/model/controller.hpp"

#include "cli/run_tool.hpp"
#include "viewer/model/depth_maker.hpp"

namespace altiro3D::viewer {

QString Controller::exportObstacle() const {
    if (exporting_) return tr("Another export is under way; export again when it is done");
    if (!document_) return tr("Nothing is open that could be exported");
    if (!frame_.setup.document || frameReading_ != readings_)
        return tr("The file is still being opened; export again when its picture is shown");
    if (frame_.request.knobs.depth != knobs_.depth)
        return tr("The depth is still being estimated; export again when the picture shows it");
    if (frame_.request.painted.revision != paintedNow().revision)
        return tr("The depth is still being changed; export again when the picture shows it");
    return {};
}

Setup Controller::exportSetup() const {
    Setup setup = frame_.setup;
    setup.knobs = knobs_;
    setup.isDraft = false;
    setup.isChosen = false;
    layFlatDepth(setup);
    return setup;
}

bool Controller::startExport(Product product, const std::filesystem::path& target) {
    if (!exportObstacle().isEmpty()) return false;
    Setup setup = exportSetup();
    exporting_ = true;
    cancelling_ = false;
    const quint64 revision = paintedNow().revision;
    exporter_.post(0, [this, setup = std::move(setup), product, target, revision] {
        QString file;
        QString problem;
        try {
            file = QString::fromStdString(writeProduct(setup, product, target, [this](double done) {
                QMetaObject::invokeMethod(
                    this, [this, done] { emit exportProgress(done); }, Qt::QueuedConnection);
                return !cancelling_;
            }));
        } catch (const std::exception& error) {
            problem = QString::fromStdString(tools::sentenceOf(error));
        }
        QMetaObject::invokeMethod(
            this,
            [this, file, problem, product, revision] {
                exporting_ = false;
                if (product == Product::Depth && !file.isEmpty()) setSaved(revision);
                emit exportEnded(file, problem);
            },
            Qt::QueuedConnection);
    });
    return true;
}

std::vector<BatchItem> Controller::batch(const std::filesystem::path& folder) const {
    const std::vector<std::filesystem::path> natives = nativesOf(sources_, folder);
    std::vector<BatchItem> items;
    for (std::size_t i = 0; i < sources_.size(); ++i) {
        items.push_back({sources_[i], knobsOf(sources_[i].file), natives[i], {}});
        for (const auto& [key, painted] : painted_) {
            const auto& [file, depth, reading, from] = key;
            if (file == sources_[i].file && depth == sources_[i].depth &&
                reading == static_cast<int>(sources_[i].reading))
                items.back().painted[from] = painted.depth;
        }
    }
    return items;
}

bool Controller::startExportAll(const std::filesystem::path& folder) {
    if (exporting_ || sources_.empty()) return false;
    exporting_ = true;
    cancelling_ = false;
    exporter_.post(0, [this, items = batch(folder), display = display_, maker = depthMaker_] {
        const auto tell = [this](double done) {
            QMetaObject::invokeMethod(
                this, [this, done] { emit exportProgress(done); }, Qt::QueuedConnection);
            return !cancelling_;
        };
        const BatchReport report = exportBatch(items, display, maker, tell);
        QMetaObject::invokeMethod(
            this,
            [this, report] {
                exporting_ = false;
                emit exportAllEnded(report);
            },
            Qt::QueuedConnection);
    });
    return true;
}

} // namespace altiro3D::viewer
