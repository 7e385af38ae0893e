#include "home.hpp"

#include <QApplication>
#include <clocale>
#include <cstring>
#include <gtest/gtest.h>

#ifdef ALTIRO3D_TOOL_PHOTO2NATIVE // the viewer is tested as well
#include "viewer/model/depth_maker.hpp"
#endif

int main(int argc, char** argv) {
#ifdef ALTIRO3D_TOOL_PHOTO2NATIVE
    using namespace altiro3D::viewer;
    if (argc == 3 && std::strcmp(argv[1], kTryNetwork) == 0) return tryNetwork(argv[2]);
#endif
    const altiro3D::test::Home home;
    qputenv("QT_QPA_PLATFORM", "offscreen");
    qputenv("SDL_AUDIODRIVER", "dummy"); // nobody hears the tests
    ::testing::InitGoogleTest(&argc, argv);
    if (::testing::GTEST_FLAG(list_tests)) return RUN_ALL_TESTS(); // takes no desktop
    const QApplication application(argc, argv);
    std::setlocale(LC_NUMERIC, "C");
    QCoreApplication::setOrganizationName("altiro3D");
    QCoreApplication::setApplicationName("tests");
    return RUN_ALL_TESTS();
}
