#include "support/tiny_network.hpp"
#include "viewer/window/network_dialog.hpp"
#include "viewer_scenes.hpp"
#include "window_actions.hpp"

#include <QComboBox>
#include <QLabel>
#include <QProgressBar>
#include <QPushButton>
#include <QSettings>
#include <QTcpServer>
#include <QTcpSocket>
#include <gtest/gtest.h>

namespace altiro3D::test {
namespace {

namespace fs = std::filesystem;
using namespace viewer;

// A server on this machine that answers each request for a file in one way.
class FileServer : public QTcpServer {
  public:
    enum class Answer { File, OtherBytes, LongerFile, CutOff, NotThere, Redirect, Silence };

    explicit FileServer(std::string file) : file_(std::move(file)) {
        listen(QHostAddress::LocalHost);
        connect(this, &QTcpServer::newConnection, this, [this] {
            QTcpSocket* const socket = nextPendingConnection();
            connect(socket, &QTcpSocket::disconnected, socket, &QObject::deleteLater);
            connect(socket, &QTcpSocket::readyRead, socket, [this, socket] { answerTo(socket); });
        });
    }
    QByteArray url() const { return "http://127.0.0.1:" + QByteArray::number(serverPort()); }

    Answer answer = Answer::File;

  private:
    void answerTo(QTcpSocket* socket) {
        const QByteArray request = socket->readAll();
        std::string body = file_;
        std::string head = "200 OK";
        std::string more;
        switch (answer) {
        case Answer::File:
            break;
        case Answer::OtherBytes:
            body.back() = static_cast<char>(body.back() ^ 1);
            break;
        case Answer::LongerFile:
            body += "more";
            break;
        case Answer::CutOff:
        case Answer::Silence:
            body.resize(body.size() / 2);
            break;
        case Answer::NotThere:
            head = "404 Not Found";
            body = "<html>no such file</html>";
            break;
        case Answer::Redirect:
            if (!request.startsWith("GET /moved")) {
                head = "302 Found";
                more = "Location: /moved\r\n";
                body.clear();
            }
            break;
        }
        const bool isShort = answer == Answer::CutOff || answer == Answer::Silence;
        const std::size_t length = isShort ? file_.size() : body.size();
        socket->write(QByteArray::fromStdString("HTTP/1.1 " + head + "\r\n" + more +
                                                "Content-Length: " + std::to_string(length) +
                                                "\r\nConnection: close\r\n\r\n" + body));
        if (answer != Answer::Silence) socket->disconnectFromHost();
    }

    std::string file_;
};

// A catalogue whose first network, "better", is not installed; "tiny" is.
class ViewerNetworkDownload : public ::testing::Test {
  protected:
    void SetUp() override {
        QSettings().clear();
        writeTinyNetwork(models_.path());
        const std::string known = slurp(models_ / "catalog.json");
        const std::string entry = known.substr(known.find("{\"name\""));
        const std::string hash =
            QCryptographicHash::hash(QByteArray::fromStdString(file_), QCryptographicHash::Sha256)
                .toHex()
                .toStdString();
        spill(
            models_ / "catalog.json",
            R"({"networks": [{"name": "better", "file": "better.onnx", "inputWidth": 32,)"
            R"( "inputHeight": 32, "licence": "MIT", "url": "https://nowhere.invalid/better.onnx",)"
            R"( "bytes": )" +
                std::to_string(file_.size()) + R"(, "sha256": ")" + hash + R"("}, )" + entry);
        hash_ = QString::fromStdString(hash);
        for (const char* name : {"ALTIRO3D_MODELS", "XDG_DATA_HOME"})
            before_.emplace_back(name, qgetenv(name));
        qputenv("ALTIRO3D_MODELS", toName(models_.path()).toUtf8());
        qputenv("XDG_DATA_HOME", toName(home_.path()).toUtf8());
        qputenv("ALTIRO3D_MODEL_BASE_URL", server_.url());
    }
    void TearDown() override {
        for (const auto& [name, value] : before_)
            qputenv(name, value);
        qunsetenv("ALTIRO3D_MODEL_BASE_URL");
    }

    // Tries a download. @return its problem
    QString problemOf(FileServer::Answer answer) {
        server_.answer = answer;
        NetworkDownload download(networkToDownload().value(), networkFolder());
        QString problem;
        bool isOver = false;
        QObject::connect(&download, &NetworkDownload::ended, &download, [&](const QString& why) {
            problem = why;
            isOver = true;
        });
        download.start();
        EXPECT_TRUE(waitFor([&] { return isOver; }));
        EXPECT_FALSE(download.isRunning());
        return problem;
    }
    bool isFolderEmpty() const {
        return !fs::exists(networkFolder()) || fs::is_empty(networkFolder());
    }

    TemporaryDirectory models_;
    TemporaryDirectory home_;
    std::string file_ = onnx::mixModel({0.5F, 0.3F, 0.2F}, {0, 0});
    QString hash_;
    FileServer server_{file_};
    std::vector<std::pair<const char*, QByteArray>> before_;
};

TEST_F(ViewerNetworkDownload, KeepsOnlyTheFileOfTheCatalogue) {
    using Answer = FileServer::Answer;
    for (const auto& [answer, words] :
         {std::pair{Answer::OtherBytes, "SHA-256 differs"}, std::pair{Answer::LongerFile, "larger"},
          std::pair{Answer::CutOff, "before all of the file"},
          std::pair{Answer::NotThere, "status 404"}}) {
        const QString problem = problemOf(answer);
        EXPECT_TRUE(problem.contains(words)) << problem.toStdString();
        EXPECT_TRUE(isFolderEmpty()) << words;
    }
    EXPECT_EQ(problemOf(Answer::Redirect), "");
    EXPECT_EQ(slurp(networkFolder() / "better.onnx"), file_);
    EXPECT_FALSE(networkToDownload());
    EXPECT_EQ(standardNetwork()->profile.name, "better");
    fs::remove(networkFolder() / "better.onnx");
    server_.close();
    const QString problem = problemOf(Answer::File);
    EXPECT_TRUE(problem.contains("cannot be reached")) << problem.toStdString();
    EXPECT_TRUE(problem.contains("with a browser") && // as get-models.sh says
                problem.contains(toName(networkFolder() / "better.onnx")));
    fs::remove(networkFolder());
    spill(networkFolder(), "a file");
    EXPECT_TRUE(problemOf(Answer::File).contains("cannot be written"));
}

TEST_F(ViewerNetworkDownload, TheWindowTellsWhatItIsDownloadsItAndUsesIt) {
    const auto window = shownWindow();
    Model& model = window->model();
    writeImage(home_ / "photo.png", detailedPhoto({120, 160}));
    dropOn(*window, {home_ / "photo.png"});
    ASSERT_TRUE(waitFor([&] { return model.stage.frame().setup.depthSource == "tiny"; }));
    QAbstractButton* const offer = window->findChild<QAbstractButton*>("betterDepth");
    EXPECT_TRUE(offer->isVisible());

    const auto inDialog = [&](const std::function<void(NetworkDialog&)>& act) {
        QTimer::singleShot(0, window.get(), [&] {
            auto* dialog = qobject_cast<NetworkDialog*>(QApplication::activeModalWidget());
            ASSERT_NE(dialog, nullptr);
            act(*dialog);
        });
        offer->click();
    };
    const auto textOf = [](NetworkDialog& dialog, const char* name) {
        return dialog.findChild<QLabel*>(name)->text().remove(QChar(0x200B));
    };
    // cancelled in the middle: nothing is left
    server_.answer = FileServer::Answer::Silence;
    inDialog([&](NetworkDialog& dialog) {
        EXPECT_EQ(textOf(dialog, "networkAddress"), server_.url() + "/better.onnx");
        EXPECT_EQ(textOf(dialog, "networkSize"), "0.0 MB");
        EXPECT_EQ(textOf(dialog, "networkHash"), hash_);
        EXPECT_EQ(textOf(dialog, "networkLicence"), "MIT");
        EXPECT_TRUE(isFolderEmpty()); // before anything was agreed to
        dialog.findChild<QPushButton*>("download")->click();
        EXPECT_TRUE(waitFor([&] { return dialog.findChild<QProgressBar*>()->value() > 400; }));
        dialog.reject();
        EXPECT_TRUE(isFolderEmpty());
    });
    EXPECT_EQ(model.stage.frame().setup.depthSource, "tiny");

    // a failure is told, and the next try succeeds
    inDialog([&](NetworkDialog& dialog) {
        server_.answer = FileServer::Answer::NotThere;
        auto* begin = dialog.findChild<QPushButton*>("download");
        begin->click();
        EXPECT_TRUE(waitFor([&] { return begin->isEnabled(); }));
        EXPECT_TRUE(textOf(dialog, "networkState").contains("404"));
        server_.answer = FileServer::Answer::File;
        begin->click();
    });
    EXPECT_TRUE(fs::exists(networkFolder() / "better.onnx"));
    EXPECT_FALSE(offer->isVisible());
    EXPECT_GE(window->findChild<QComboBox*>("depth")->findText("better"), 0);
    EXPECT_TRUE(waitFor([&] { return model.stage.frame().setup.depthSource == "better"; }));
}

} // namespace
} // namespace altiro3D::test
