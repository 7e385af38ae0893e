// The logic of a show: its order, its times and its memory, without windows and with a clock of the
// test's own.

#include "viewer/show/slide_show.hpp"

#include <algorithm>
#include <cmath>
#include <gtest/gtest.h>
#include <map>
#include <opencv2/core.hpp>
#include <set>

namespace altiro3D::test {
namespace {

using namespace viewer;

std::vector<Source> filesNamed(const std::vector<std::string>& names) {
    std::vector<Source> files;
    for (const std::string& name : names)
        files.push_back({name, {}, Reading::Automatic});
    return files;
}

std::string nameOf(const std::optional<Source>& source) {
    return source ? source->file.string() : "-";
}

// The names that next() goes through, with the current one first if there is one.
std::string walk(ShowList& list, int steps) {
    std::string names;
    for (int i = 0; i < steps; ++i)
        names += list.next() ? nameOf(list.current()) : "-";
    return names;
}

TEST(ShowList, GoesOnAndBackAndAround) {
    ShowList once(false, false, 1);
    EXPECT_EQ(nameOf(once.following()), "-");
    EXPECT_FALSE(once.next());
    once.set(filesNamed({"a", "b", "c"}));
    EXPECT_EQ(nameOf(once.current()), "-"); // before the first
    EXPECT_EQ(walk(once, 4), "abc-");
    EXPECT_EQ(nameOf(once.current()), "c");
    EXPECT_TRUE(once.previous());
    EXPECT_TRUE(once.previous());
    EXPECT_FALSE(once.previous());
    EXPECT_EQ(nameOf(once.current()), "a");
    ShowList loop(false, true, 1);
    loop.set(filesNamed({"a", "b"}));
    EXPECT_EQ(walk(loop, 5), "ababa");
    EXPECT_TRUE(loop.previous());
    EXPECT_EQ(nameOf(loop.current()), "b");
    ShowList single(false, true, 1);
    single.set(filesNamed({"a"}));
    EXPECT_EQ(walk(single, 3), "aaa");
}

TEST(ShowList, FilesJoinAndLeave) {
    ShowList list(false, true, 1);
    list.set(filesNamed({"b", "d", "f"}));
    EXPECT_EQ(walk(list, 2), "bd");
    list.set(filesNamed({"a", "b", "c", "d", "e", "f"}));
    EXPECT_EQ(nameOf(list.current()), "d");
    EXPECT_EQ(nameOf(list.following()), "e");
    EXPECT_EQ(nameOf(list.preceding()), "c");
    list.set(filesNamed({"a", "b", "e", "f"})); // without the current one
    EXPECT_EQ(nameOf(list.current()), "-");
    EXPECT_EQ(nameOf(list.preceding()), "b");
    EXPECT_EQ(walk(list, 3), "efa");
    list.set(filesNamed({"b", "e"}));
    EXPECT_EQ(nameOf(list.following()), "b");
    list.set({});
    EXPECT_EQ(nameOf(list.following()), "-");
    EXPECT_FALSE(list.next());
    list.set(filesNamed({"x"}));
    EXPECT_EQ(walk(list, 2), "xx");
    // the last one leaves
    list.set(filesNamed({"x", "y"}));
    EXPECT_EQ(walk(list, 1), "y");
    list.set(filesNamed({"x"}));
    EXPECT_EQ(walk(list, 1), "x");
}

TEST(ShowList, ShufflingShowsEachOnceInARound) {
    const std::vector<std::string> names = {"a", "b", "c", "d", "e", "f", "g"};
    std::set<std::string> orders;
    for (unsigned seed = 0; seed < 40; ++seed) {
        ShowList list(true, true, seed);
        list.set(filesNamed(names));
        std::string before;
        for (int round = 0; round < 5; ++round) {
            std::string order;
            for (std::size_t i = 0; i < names.size(); ++i) {
                const std::string follows = nameOf(list.following());
                ASSERT_TRUE(list.next());
                EXPECT_EQ(nameOf(list.current()), follows);
                EXPECT_NE(nameOf(list.current()), before);
                before = nameOf(list.current());
                order += before;
            }
            orders.insert(order);
            std::sort(order.begin(), order.end());
            EXPECT_EQ(order, "abcdefg");
        }
    }
    EXPECT_GT(orders.size(), 150U); // of 200
    // A new file is shown in this round, a file that has gone is not.
    ShowList list(true, false, 3);
    list.set(filesNamed({"a", "b", "c"}));
    std::string order = walk(list, 2);
    std::vector<std::string> now = {"n"};
    for (const char* name : {"a", "b", "c"}) {
        if (order.find(name) == std::string::npos) now.emplace_back(name);
    }
    list.set(filesNamed(now));
    order = walk(list, 3);
    EXPECT_EQ(order.back(), '-');
    std::sort(order.begin(), order.end());
    EXPECT_EQ(order.substr(1), now[1] + "n");
}

// A show whose slides are made `delay` s after they were asked for.
class Show {
  public:
    explicit Show(const SlideShow::Settings& settings, double delay = 0)
        : delay_(delay),
          show_(settings, {[this](const Source& source) {
                               asked_.push_back({source, now_});
                           },
                           [this](const std::string& why) { problems.push_back(why); }}) {}

    SlideShow& operator*() { return show_; }
    SlideShow* operator->() { return &show_; }

    void runUntil(double end, double step = 0.05) {
        for (; now_ < end && !show_.isOver(); now_ += step) {
            const auto asked = asked_;
            for (const auto& [source, time] : asked) {
                if (now_ < time + delay_) continue;
                asked_.erase(asked_.begin());
                show_.put(slideOf(source));
            }
            show_.tick(now_);
            most = std::max(most, show_.slidesKept());
            if (show_.changes() == changes_) continue;
            changes_ = show_.changes();
            seen.push_back({nameOf(show_.shown()->source), now_});
        }
    }
    std::string names() const {
        std::string all;
        for (const auto& [name, time] : seen)
            all += name;
        return all;
    }
    double now() const { return now_; }

    std::vector<std::pair<std::string, double>> seen; // and when
    std::vector<std::string> problems;
    std::size_t most = 0;

  private:
    static Slide slideOf(const Source& source) {
        Slide slide;
        slide.source = source;
        const std::string name = source.file.string();
        if (name[0] == '!') {
            slide.problem = name + ": is damaged";
            return slide;
        }
        slide.native = cv::Mat(4, 3, CV_8UC3, cv::Scalar::all(name[0]));
        if (name[0] == 'V')
            slide.nativeOfFrame = [](const cv::Mat& frame, double) { return frame; };
        return slide;
    }

    double delay_;
    double now_ = 0;
    std::vector<std::pair<Source, double>> asked_;
    int changes_ = 0;
    SlideShow show_;
};

SlideShow::Settings every(double seconds, bool loops = false) {
    SlideShow::Settings settings;
    settings.each = seconds;
    settings.loops = loops;
    return settings;
}

TEST(SlideShow, ShowsEachForItsTimeAndEnds) {
    Show show(every(3), 0.4);
    show->setFiles(filesNamed({"a", "b", "c"}));
    show.runUntil(100);
    EXPECT_TRUE(show->isOver());
    EXPECT_EQ(show.names(), "abc");
    for (std::size_t i = 1; i < show.seen.size(); ++i) // the next one was made in time
        EXPECT_NEAR(show.seen[i].second - show.seen[i - 1].second, 3, 0.11);
    EXPECT_NEAR(show.now() - show.seen.back().second, 3, 0.11);
}

TEST(SlideShow, WaitsForASlideThatTakesLong) {
    Show show(every(1, true), 5);
    show->setFiles(filesNamed({"a", "b"}));
    show.runUntil(16);
    EXPECT_EQ(show.names().substr(0, 2), "ab");
    EXPECT_NEAR(show.seen[1].second - show.seen[0].second, 5, 0.2);
}

TEST(SlideShow, FadesByABlendOfBothNatives) {
    SlideShow::Settings settings = every(2);
    settings.fade = 0.5;
    Show show(settings);
    show->setFiles(filesNamed({"a", "z"}));
    cv::Mat picture;
    show.runUntil(1);
    EXPECT_FALSE(show->isFading());
    show->blend(show->shown()->native, picture);
    EXPECT_EQ(picture.at<cv::Vec3b>(0, 0)[0], 'a');
    bool hasFaded = false;
    while (show.now() < 3.5) {
        show.runUntil(show.now() + 0.01, 0.02);
        if (show.seen.size() < 2) continue;
        const double share = std::min((show.now() - 0.02 - show.seen[1].second) / 0.5, 1.0);
        show->blend(show->shown()->native, picture);
        EXPECT_NEAR(picture.at<cv::Vec3b>(3, 2)[1], 'a' + ('z' - 'a') * share, 1.01) << share;
        hasFaded = hasFaded || (share > 0.2 && share < 0.8);
        EXPECT_EQ(show->isFading(), share < 1);
    }
    EXPECT_TRUE(hasFaded);
}

TEST(SlideShow, KeysAndPauses) {
    Show show(every(10, true));
    show->setFiles(filesNamed({"a", "b", "c", "d"}));
    show.runUntil(1);
    show->next();
    show->next(); // at once: b is never shown
    show.runUntil(2);
    EXPECT_EQ(show.names(), "ac");
    show->previous();
    show.runUntil(3);
    EXPECT_EQ(show.names(), "acb");
    show->setPaused(true);
    show.runUntil(60);
    EXPECT_EQ(show.names(), "acb");
    show->next(); // also while it is paused
    show.runUntil(61);
    EXPECT_EQ(show.names(), "acbc");
    EXPECT_FALSE(show->isFading()); // the pause does not stop a fade
    show->setPaused(false);
    show.runUntil(69);
    EXPECT_EQ(show.names(), "acbc"); // the pause did not count
    show.runUntil(72);
    EXPECT_EQ(show.names(), "acbcd");
}

TEST(SlideShow, AVideoIsShownToItsEnd) {
    Show show(every(2));
    show->setFiles(filesNamed({"a", "V", "b"}));
    show.runUntil(50);
    EXPECT_EQ(show.names(), "aV");
    show->endVideo();
    show.runUntil(60);
    EXPECT_EQ(show.names(), "aVb");
    EXPECT_TRUE(show->isOver());
}

TEST(SlideShow, WhatCannotBeShownIsReportedAndNoEnd) {
    Show show(every(2, true));
    show->setFiles(filesNamed({"!1", "a", "!2", "b"}));
    show.runUntil(13);
    EXPECT_EQ(show.names().substr(0, 5), "ababa");
    EXPECT_EQ(show.problems, (std::vector<std::string>{"!1: is damaged", "!2: is damaged"}));
    show->setFiles(filesNamed({"!1", "a", "!2", "b"})); // the folder was read again
    show.runUntil(20);
    EXPECT_EQ(show.problems.size(), 2U);
    Show none(every(2, true));
    none->setFiles(filesNamed({"!1", "!2"}));
    none.runUntil(10);
    EXPECT_TRUE(none->isOver());
    EXPECT_FALSE(none->hasShown());
}

TEST(SlideShow, ADayWithFilesThatComeAndGoStaysSmall) {
    SlideShow::Settings settings;
    settings.loops = true;
    settings.shuffles = true;
    settings.seed = 7;
    Show show(settings, 0.7);
    std::vector<std::string> names;
    for (char name = 'a'; name <= 'p'; ++name)
        names.emplace_back(1, name);
    show->setFiles(filesNamed(names));
    constexpr int kDay = 24 * 3600;
    for (int step = 0; step < kDay / 600; ++step) { // a change every ten minutes
        std::vector<std::string> now = names;
        now.erase(now.begin() + step % 16);
        if (step % 5 == 0) now.emplace_back("!" + std::to_string(step));
        if (step % 3 == 0) now.emplace_back("z");
        show->setFiles(filesNamed(now));
        show.runUntil(600.0 * (step + 1), 0.25);
        ASSERT_FALSE(show->isOver());
    }
    // 20 s each, and never a picture that is not there for want of the next one
    EXPECT_NEAR(static_cast<double>(show.seen.size()), kDay / 20.0, kDay / 20.0 * 0.03);
    EXPECT_LE(show.most, 4U);
    std::map<std::string, int> counts;
    for (const auto& [name, time] : show.seen)
        ++counts[name];
    EXPECT_EQ(counts.size(), 17U);
    for (const std::string& name : names)
        EXPECT_GT(counts[name], 150) << name;
}

} // namespace
} // namespace altiro3D::test
