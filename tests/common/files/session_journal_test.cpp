// SPDX-License-Identifier: Apache-2.0
#include "common/files/session_journal.h"

#include <gmock/gmock.h>
#include <sys/resource.h>

#include <csignal>
#include <nlohmann/json.hpp>

#include "tests/common/files/temporary_folder.h"

namespace dermap {
namespace {

using nlohmann::json;
using testing::AllOf;
using testing::HasSubstr;

// JSON Lines (jsonlines.org): one value a line.
TEST(Journal, KeepsEventsInOrderAndOnOneLineEach) {
  const TemporaryFolder folder;
  const auto path = folder / "session/journal.jsonl";
  {
    Journal journal(path);
    journal.Append({{"event", "start"}, {"notes", "two\nlines"}});
    journal.Append({{"event", "frame"}, {"number", 1}});
  }
  {
    Journal journal(path);
    journal.Append({{"event", "end"}});
  }
  const std::string text = Slurp(path);
  EXPECT_EQ(std::count(text.begin(), text.end(), '\n'), 3);
  const auto events = ReadJournal(path);
  ASSERT_EQ(events.size(), 3u);
  EXPECT_EQ(events[0]["notes"], "two\nlines");
  EXPECT_EQ(events[2]["event"], "end");
}

// A power cut may leave any part of the last line: at every length the whole lines are read, and going on
// mends it.
TEST(Journal, SurvivesATornLastLineOfAnyLength) {
  const TemporaryFolder folder;
  const auto path = folder / "journal.jsonl";
  {
    Journal journal(path);
    journal.Append(
        {{"number", 1}, {"file", "frames/0001_black_0nm.dng"}});  // longer than what follows a tear
    journal.Append({{"number", 2}, {"file", "frames/0002_skin_450nm.dng"}});
  }
  const std::string whole = Slurp(path);
  for (std::size_t length = 0; length <= whole.size(); ++length) {
    folder.Write("journal.jsonl", whole.substr(0, length));
    const auto lines = static_cast<std::size_t>(
        std::count(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(length), '\n'));
    ASSERT_EQ(ReadJournal(path).size(), lines) << length;
    Journal(path).Append({{"number", 3}});
    const auto events = ReadJournal(path);
    ASSERT_EQ(events.size(), lines + 1) << length;
    ASSERT_EQ(events.back()["number"], 3) << length;
  }
}

// A damaged line that is not the last was confirmed once: it must not be dropped in silence.
TEST(Journal, NamesADamagedLine) {
  const TemporaryFolder folder;
  const auto path = folder.Write("journal.jsonl", "{\"a\":1}\n{\"a\":\n{\"a\":3}\n");
  EXPECT_THAT(SentenceOf<InputError>([&] { ReadJournal(path); }),
              AllOf(HasSubstr("journal.jsonl line 2"), HasSubstr("remedy")));
  folder.Write("journal.jsonl", "[1]\n");
  EXPECT_THAT(SentenceOf<InputError>([&] { ReadJournal(path); }), HasSubstr("line 1"));
}

// flock(2): the lock belongs to the open file, so a second opening in the same process is refused as well.
TEST(Journal, IsHeldByOneAtATime) {
  const TemporaryFolder folder;
  const auto path = folder / "journal.jsonl";
  {
    const Journal journal(path);
    EXPECT_THAT(SentenceOf<InputError>([&] { Journal second(path); }),
                HasSubstr("in use by another capture"));
  }
  EXPECT_NO_THROW(Journal again(path));
}

// setrlimit(2): writes past RLIMIT_FSIZE fail; the journal must end with the last whole line and go on
// afterwards.
TEST(Journal, StaysWholeWhereTheDiskIsFull) {
  const TemporaryFolder folder;
  const auto path = folder / "journal.jsonl";
  Journal journal(path);
  journal.Append({{"number", 1}});
  std::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  rlimit limit = before;
  limit.rlim_cur = 100;
  ::setrlimit(RLIMIT_FSIZE, &limit);
  const std::string sentence = SentenceOf<StorageError>([&] {
    journal.Append({{"text", std::string(1000, 'x')}});
  });
  ::setrlimit(RLIMIT_FSIZE, &before);
  EXPECT_THAT(sentence, HasSubstr("journal.jsonl"));
  EXPECT_EQ(Slurp(path), "{\"number\":1}\n");
  journal.Append({{"number", 2}});
  EXPECT_EQ(ReadJournal(path).size(), 2u);
}

// Nothing happened yet.
TEST(Journal, IsEmptyWhereThereIsNone) {
  EXPECT_TRUE(ReadJournal("no/such/journal.jsonl").empty());
}

}  // namespace
}  // namespace dermap
