#include "cli/bridge.hpp"

#include "altiro3D/error.hpp"
#include "altiro3D/image_io.hpp"
#include "altiro3D/video_io.hpp"
#include "cli/bridge_server.hpp"
#include "cli/depth_options.hpp"
#include "cli/folders.hpp"
#include "cli/outputs.hpp"

#include <QCoreApplication>
#include <QEventLoop>
#include <QHostInfo>
#include <QNetworkAccessManager>
#include <QNetworkInterface>
#include <QNetworkProxy>
#include <QNetworkReply>
#include <QTcpSocket>
#include <QTimer>
#include <QUrl>
#include <algorithm>
#include <chrono>
#include <cmath>
#include <future>
#include <memory>
#include <nlohmann/json.hpp>

namespace altiro3D::tools {

namespace fs = std::filesystem;
using Json = nlohmann::ordered_json;

namespace {

constexpr int kStandardPort = 33334;
constexpr int kPatienceMilliseconds = 6000; // for one answer
constexpr qint64 kMaxAnswerBytes = 4 << 20;

QUrl addressOf(const std::string& text) {
    const bool isAuto = text == "auto";
    QUrl url("http://" + (isAuto ? QString("localhost") : QString::fromStdString(text)),
             QUrl::StrictMode);
    const bool isAddress = url.isValid() && !url.host().isEmpty() && url.userInfo().isEmpty() &&
                           url.path().isEmpty() && !url.hasQuery() && !url.hasFragment();
    if (!isAddress) throw UsageError("--bridge is " + text + ", expected auto or HOST:PORT");
    url.setPort(url.port(kStandardPort));
    return url;
}

// Requires that many threads can run at the same time. @throws std::system_error
void requireThreads(int count) {
    if (count > 0) std::async(std::launch::async, requireThreads, count - 1).get();
}

constexpr int kThreadsOfQt = 5; // connections, D-Bus, HTTP, two for names

// Qt's network needs an application; the viewer may have none yet. Qt waits for ever for a thread
// that cannot be started.
class NetworkUse {
  public:
    NetworkUse() {
        requireThreads(kThreadsOfQt);
        if (QCoreApplication::instance() == nullptr)
            own_ = std::make_unique<QCoreApplication>(count_, words_);
    }

  private:
    int count_ = 1;
    char name_[9] = "altiro3D";
    char* words_[2] = {name_, nullptr};
    std::unique_ptr<QCoreApplication> own_;
};

// A session of a Bridge.
class Session {
  public:
    explicit Session(const std::string& address)
        : url_(addressOf(address)), name_(bridgeName(address)) {
        manager_.setProxy(QNetworkProxy::NoProxy);
        token_ = bridgeToken(put("enter_orchestration", {{"name", "default"}}), name_);
    }

    std::vector<BridgeDevice> devices() {
        return bridgeDevices(put("available_output_devices", {{"orchestration", token_}}), name_);
    }

    // A call of the session. @param fields without the token
    void call(const std::string& endpoint, Json fields) {
        fields["orchestration"] = token_;
        requireBridgeAnswer(put(endpoint, fields), name_ + " (" + endpoint + ")");
    }

  private:
    [[noreturn]] void fail(const std::string& problem) const {
        throw Error(ErrorCode::ReadFailed, name_, problem + ", expected a running Bridge");
    }

    std::string put(const std::string& endpoint, const Json& fields) {
        QUrl url = url_;
        url.setPath(QString::fromStdString("/" + endpoint));
        QNetworkRequest request(url);
        request.setHeader(QNetworkRequest::ContentTypeHeader, "application/json");
        const std::string body = fields.dump(-1, ' ', false, Json::error_handler_t::replace);
        const std::unique_ptr<QNetworkReply> reply(
            manager_.put(request, QByteArray::fromStdString(body)));
        QEventLoop loop;
        QTimer patience;
        QByteArray answer;
        bool isTooLarge = false;
        const auto take = [&] {
            answer += reply->readAll();
            isTooLarge = answer.size() > kMaxAnswerBytes;
            if (isTooLarge) loop.quit();
        };
        QObject::connect(reply.get(), &QNetworkReply::readyRead, &loop, take);
        QObject::connect(reply.get(), &QNetworkReply::finished, &loop, &QEventLoop::quit);
        QObject::connect(&patience, &QTimer::timeout, &loop, &QEventLoop::quit);
        patience.setSingleShot(true);
        patience.start(kPatienceMilliseconds);
        if (!reply->isFinished()) loop.exec();
        take();
        if (isTooLarge) fail("answers with more than 4 MB");
        if (!reply->isFinished()) fail("does not answer");
        if (reply->error() != QNetworkReply::NoError)
            fail("cannot be reached (" + oneLine(reply->errorString().toStdString()) + ")");
        return answer.toStdString();
    }

    QNetworkAccessManager manager_;
    QUrl url_;
    std::string name_;
    std::string token_;
};

// The connection that reaches a Bridge: both ends of it.
struct Ends {
    QHostAddress own;
    QHostAddress bridge;
};

Ends endsOf(const std::string& address) {
    const QUrl url = addressOf(address);
    QTcpSocket socket;
    socket.setProxy(QNetworkProxy::NoProxy);
    socket.connectToHost(url.host(), static_cast<quint16>(url.port()));
    if (!socket.waitForConnected(kPatienceMilliseconds))
        throw Error(ErrorCode::ReadFailed, bridgeName(address),
                    "cannot be reached, expected a running Bridge");
    return {socket.localAddress(), socket.peerAddress()};
}

bool isOnThisComputer(const QHostAddress& address) {
    return address.isLoopback() || QNetworkInterface::allAddresses().contains(address);
}

Json jsonOf(const BridgeEntry& entry, std::size_t index, const std::string& uri,
            const std::string& playlist) {
    Json json = {{"name", playlist},
                 {"id", std::to_string(index)},
                 {"index", index},
                 {"uri", uri},
                 {"rows", entry.grid.rows},
                 {"cols", entry.grid.columns},
                 {"aspect", entry.aspect},
                 {"view_count", entry.grid.rows * entry.grid.columns},
                 {"durationMS", std::llround(1000 * entry.seconds)},
                 {"focus", 0},
                 {"zoom", 1},
                 {"crop_pos_x", 0},
                 {"crop_pos_y", 0},
                 {"isRGBD", entry.isRgbd ? 1 : 0},
                 {"tag", ""}};
    if (entry.isRgbd) {
        json["depth_loc"] = entry.isStacked ? 1 : 2; // below, right
        json["depth_inversion"] = 0;
        json["chroma_depth"] = 0;
        json["depthiness"] = 1.5;
    }
    return json;
}

// The entry of an RGB-D file. @throws Error of VideoReader
BridgeEntry rgbdEntry(const fs::path& file, bool isSqueezed, bool isStacked = false) {
    const VideoFacts facts = VideoReader(file).facts(); // also of pictures
    BridgeEntry entry;
    entry.file = file;
    entry.isRgbd = true;
    entry.isStacked = isStacked;
    entry.aspect = static_cast<double>(facts.size.width) / facts.size.height;
    if (!isSqueezed) entry.aspect *= isStacked ? 2 : 0.5;
    if (isVideoFileName(file)) entry.seconds = facts.duration.value_or(entry.seconds);
    return entry;
}

} // namespace

void addBridgeOptions(CommandLine& commandLine, const std::string& what, bool showsEntries) {
    commandLine.addAdvanced({"bridge"},
                            what + " Looking Glass Bridge, which runs on this computer (auto) or "
                                   "on another one (HOST:PORT).",
                            "HOST:PORT");
    if (!showsEntries) return;
    commandLine.addAdvanced(
        {"serve"},
        "With --bridge: the address of this computer under which a Bridge on another one fetches "
        "the files (default: the one that reaches it).",
        "ADDRESS");
}

std::optional<BridgeJob> bridgeJob(const CommandLine& commandLine) {
    BridgeJob job;
    commandLine.refuseWithout("bridge", {"serve"}, " applies to --bridge, expected both");
    commandLine.take({{"bridge", job.address},
                      {"serve", job.serve},
                      {"serial", job.serial},
                      {"each", job.seconds, 0.1, 1e6}});
    if (job.address.empty()) return std::nullopt;
    (void)addressOf(job.address);
    return job;
}

std::string bridgeName(const std::string& address) {
    const QUrl url = addressOf(address);
    return "Looking Glass Bridge at " + url.authority().toStdString();
}

std::vector<BridgeDevice> devicesOfBridge(const std::string& address) {
    const NetworkUse use;
    return Session(address).devices();
}

BridgeDevice deviceOfBridge(const std::string& address, const std::string& serial) {
    std::vector<BridgeDevice> meant;
    std::vector<std::string> names;
    for (const BridgeDevice& device : devicesOfBridge(address)) {
        names.push_back(device.name);
        if (serial.empty() || lowerCase(device.name) == lowerCase(serial) ||
            lowerCase(device.calibration.serial) == lowerCase(serial))
            meant.push_back(device);
    }
    if (meant.empty())
        throw Error(ErrorCode::NotFound, bridgeName(address),
                    (serial.empty() ? "has no light-field display" : "has no display " + serial) +
                        ", expected " +
                        (names.empty() ? "one that is connected" : "one of " + joined(names)));
    if (meant.size() > 1)
        throw Error(ErrorCode::InvalidArgument, bridgeName(address),
                    "has several displays, expected --serial with one of " + joined(names));
    if (!meant.front().problem.empty())
        throw Error(ErrorCode::BadFormat, bridgeName(address), meant.front().problem);
    return meant.front();
}

BridgeEntry bridgeEntry(const fs::path& file, double panelAspect) {
    if (const auto name = parseQuiltName(file)) {
        BridgeEntry entry;
        entry.file = file;
        entry.grid = name->grid;
        entry.aspect = name->aspect.value_or(panelAspect);
        if (isVideoFileName(file))
            entry.seconds = VideoReader(file).facts().duration.value_or(entry.seconds);
        return entry;
    }
    const auto scene = parseSceneName(file);
    if (!scene || scene->contents != SceneName::Contents::Rgbd)
        throw Error(
            ErrorCode::BadFormat, file.string(),
            "is neither named as a quilt nor as an RGB-D file, expected a name that ends "
            "in _qs<columns>x<rows>a<aspect> or _RGBD (photo2native --bridge shows photos)");
    return rgbdEntry(file, scene->halves == StereoHalves::Squeezed, scene->isStacked);
}

void showOnBridge(const BridgeJob& job, const std::vector<BridgeEntry>& entries,
                  Messages& messages) {
    const NetworkUse use;
    const Ends ends = endsOf(job.address);
    Session session(job.address);
    // with no display Bridge accepts everything all the same
    const std::vector<BridgeDevice> devices = session.devices();
    int head = -1;
    if (!job.serial.empty()) {
        head = deviceOfBridge(job.address, job.serial).index;
    } else if (devices.empty()) {
        throw Error(ErrorCode::NotFound, bridgeName(job.address),
                    "has no light-field display, expected one that is connected");
    }
    std::unique_ptr<BridgeServer> server;
    if (!job.serve.empty() || !isOnThisComputer(ends.bridge))
        server = std::make_unique<BridgeServer>(job.serve, ends.own, ends.bridge);
    // Bridge shows the old pictures of a name that it knows
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    const std::string playlist =
        "altiro3D-" +
        std::to_string(std::chrono::duration_cast<std::chrono::milliseconds>(now).count());
    session.call("show_window", {{"show_window", true}, {"head_index", head}});
    session.call("instance_playlist", {{"name", playlist}, {"loop", job.loops}});
    for (std::size_t i = 0; i < entries.size(); ++i) {
        const std::string uri =
            server ? server->add(entries[i].file) : fs::absolute(entries[i].file).string();
        session.call("insert_playlist_entry", jsonOf(entries[i], i, uri, playlist));
    }
    session.call("play_playlist", {{"name", playlist}, {"head_index", head}});
    messages.say(bridgeName(job.address) + ": shows " + counted(entries.size(), "file"));
    if (!server) return;
    messages.say("it fetches them from " + server->address() + "; Ctrl-C ends this");
    catchStop();
    QEventLoop loop;
    QTimer ticks;
    QObject::connect(&ticks, &QTimer::timeout, &loop, [&] {
        if (isStopWanted()) loop.quit();
    });
    ticks.start(100);
    loop.exec();
}

void showOnBridge(const BridgeJob& job, const std::vector<fs::path>& files, bool areRgbd,
                  double panelAspect, Messages& messages) {
    std::vector<BridgeEntry> entries;
    for (const fs::path& file : files) {
        entries.push_back(
            areRgbd ? rgbdEntry(file, savedRgbdLayout(file).halves == StereoHalves::Squeezed)
                    : bridgeEntry(file, panelAspect));
        if (!isVideoFileName(file)) entries.back().seconds = job.seconds;
    }
    if (!entries.empty()) showOnBridge(job, entries, messages);
}

fs::path quiltForBridge(const std::string& stem) {
    constexpr std::size_t kKept = 20;
    fs::path folder = cacheDirectory();
    if (folder.empty())
        throw Error(ErrorCode::NotFound, "quilt", "has no place, expected $HOME to be set");
    folder /= "bridge";
    std::vector<std::pair<fs::file_time_type, fs::path>> old;
    std::error_code error;
    for (fs::directory_iterator it(folder, error), end; !error && it != end; it.increment(error))
        old.emplace_back(it->last_write_time(error), it->path());
    std::sort(old.rbegin(), old.rend());
    for (std::size_t i = kKept - 1; i < old.size(); ++i)
        fs::remove(old[i].second, error);
    const auto now = std::chrono::system_clock::now().time_since_epoch();
    return folder / (std::to_string(now.count()) + "_" + inFileName(stem) + ".png");
}

} // namespace altiro3D::tools
