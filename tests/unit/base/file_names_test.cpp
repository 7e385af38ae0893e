#include "altiro3D/file_io.hpp"

#include <gtest/gtest.h>
#include <set>

using namespace altiro3D;

namespace {

// The same names as NFC and NFD, by unicodedata.normalize() of Python.
struct Forms {
    const char* composed;
    const char* decomposed;
};
constexpr Forms kForms[] = {
    {u8"Caf\u00e9", u8"Cafe\u0301"},
    {u8"\u00c5ngstr\u00f6m", u8"A\u030angstro\u0308m"},
    {u8"Vi\u1ec7t \u1ed9 \u01b0\u1eddng",
     u8"Vie\u0323\u0302t o\u0323\u0302 u\u031bo\u031b\u0300ng"},
    {u8"\u0388\u03bb\u03bb\u03ac\u03b4\u03b1 \u0390",
     u8"\u0395\u0301\u03bb\u03bb\u03b1\u0301\u03b4\u03b1 \u03b9\u0308\u0301"},
    {u8"\u0419\u043e\u0448\u043a\u0430\u0440 \u0451\u0457",
     u8"\u0418\u0306\u043e\u0448\u043a\u0430\u0440 \u0435\u0308\u0456\u0308"},
    {u8"\u304c\u30d1", u8"\u304b\u3099\u30cf\u309a"},
    {u8"\ud55c\uae00 \uac01\ubdc1",
     u8"\u1112\u1161\u11ab\u1100\u1173\u11af \u1100\u1161\u11a8\u1107\u1170\u11b0"},
    {u8"\u017d\u0219\u0173\u01da", u8"Z\u030cs\u0326u\u0328u\u0308\u030c"},
};

} // namespace

TEST(ComparableName, IsTheSameForComposedAndDecomposedLetters) {
    std::set<std::u32string> names;
    for (const Forms& forms : kForms) {
        EXPECT_NE(std::string(forms.composed), forms.decomposed);
        EXPECT_EQ(comparableName(forms.composed), comparableName(forms.decomposed))
            << forms.composed;
        names.insert(comparableName(forms.composed));
    }
    EXPECT_EQ(names.size(), std::size(kForms));
}

TEST(ComparableName, DiffersForOtherLettersAndBytes) {
    EXPECT_EQ(comparableName("IMG_1.JPG"), comparableName("img_1.jpg"));
    EXPECT_EQ(comparableName("IMG_1"), U"img_1");
    // cafe, cafè, CAFÉ (only A to Z have no case), Latin-1, a truncated letter, marks alone
    const char* const others[] = {"Cafe",
                                  u8"Caf\u00e9",
                                  u8"Caf\u00e8",
                                  u8"CAF\u00c9",
                                  "Caf\xe9",
                                  "Caf\xc3",
                                  "Caf\xc3\xe9",
                                  "Caf\xa9",
                                  u8"Caf\u0301",
                                  u8"\u0301Caf",
                                  u8"Cafe\u0301\u0301",
                                  u8"Cafe\u0316\u0301",
                                  u8"\U0001f600",
                                  "\xf0\x9f\x98",
                                  ""};
    std::set<std::u32string> names;
    for (const char* other : others)
        names.insert(comparableName(other));
    EXPECT_EQ(names.size(), std::size(others));
}

TEST(ShellWord, IsQuotedIfItNeedsIt) {
    EXPECT_EQ(shellWord("film_2.mp4"), "film_2.mp4");
    EXPECT_EQ(shellWord(u8"Caf\u00e9.mp4"), u8"Caf\u00e9.mp4");
#ifdef _WIN32
    EXPECT_EQ(shellWord("a b"), "\"a b\"");
    EXPECT_EQ(shellWord("it's"), "\"it's\"");
    EXPECT_EQ(shellWord("C:\\a\"b"), "\"C:\\a\\\"b\"");
    EXPECT_EQ(shellWord(""), "\"\"");
#else
    EXPECT_EQ(shellWord("a b"), "'a b'");
    EXPECT_EQ(shellWord("it's"), "'it'\\''s'");
    EXPECT_EQ(shellWord(""), "''");
#endif
}
