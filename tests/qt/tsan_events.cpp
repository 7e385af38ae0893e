// In builds with ThreadSanitizer only, which cannot see how Qt, built without it, hands calls from
// thread to thread: what came before QMetaObject::invokeMethod() in one thread comes before the
// events that another thread handles after it.

#include <QCoreApplication>
#include <QEvent>
#include <dlfcn.h>
#include <sanitizer/tsan_interface.h>

namespace {

char queue; // represents the queues of all threads

class Acquirer : public QObject {
    bool eventFilter(QObject*, QEvent*) override {
        __tsan_acquire(&queue);
        return false;
    }
};

void installAcquirer() {
    auto* const application = QCoreApplication::instance();
    auto* const acquirer = new Acquirer;
    acquirer->setParent(application);
    application->installEventFilter(acquirer);
}
Q_COREAPP_STARTUP_FUNCTION(installAcquirer)

} // namespace

bool QMetaObject::invokeMethodImpl(QObject* object, QtPrivate::QSlotObjectBase* slot,
                                   Qt::ConnectionType type, void* result) {
    using Function = bool (*)(QObject*, QtPrivate::QSlotObjectBase*, Qt::ConnectionType, void*);
    static const auto original = reinterpret_cast<Function>(
        dlsym(RTLD_NEXT, "_ZN11QMetaObject16invokeMethodImplEP7QObjectPN9QtPrivate15QSlotObjectBase"
                         "EN2Qt14ConnectionTypeEPv"));
    __tsan_release(&queue);
    return original(object, slot, type, result);
}
