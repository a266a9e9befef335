// SPDX-License-Identifier: Apache-2.0
#include "common/files/atomic_file.h"

#include <gmock/gmock.h>
#include <sys/resource.h>
#include <sys/stat.h>

#include <csignal>
#include <cstring>

#include "tests/common/files/temporary_folder.h"

namespace dermap {
namespace {

using testing::ElementsAre;
using testing::HasSubstr;
using testing::IsEmpty;

// While alive, no file of this process may grow beyond a size: a full disk that needs no disk.
class FileSizeLimit {
 public:
  explicit FileSizeLimit(rlim_t bytes) {
    std::signal(SIGXFSZ, SIG_IGN);
    ::getrlimit(RLIMIT_FSIZE, &before_);
    rlimit limit = before_;
    limit.rlim_cur = bytes;
    ::setrlimit(RLIMIT_FSIZE, &limit);
  }
  ~FileSizeLimit() { ::setrlimit(RLIMIT_FSIZE, &before_); }

 private:
  rlimit before_{};
};

// The contract of the header: whole contents under the name, nothing else in the folder, parents made.
TEST(WriteFileAtomically, WritesContentsAndMakesParentFolders) {
  const TemporaryFolder folder;
  WriteFileAtomically(folder / "a/b/c.txt", std::string("line\n\0end", 9));
  EXPECT_EQ(Slurp(folder / "a/b/c.txt"), std::string("line\n\0end", 9));
  EXPECT_THAT(folder.Names(), testing::UnorderedElementsAre("a", "a/b", "a/b/c.txt"));
  const std::array<std::byte, 2> bytes{std::byte{7}, std::byte{255}};
  WriteFileAtomically(folder / "a/b/c.txt", bytes);
  EXPECT_EQ(Slurp(folder / "a/b/c.txt"), "\x07\xff");
}

// open(2): a new file has mode 0666 less the umask, whatever the temporary file did.
TEST(WriteFileAtomically, LeavesOrdinaryPermissions) {
  const TemporaryFolder folder;
  const mode_t mask = ::umask(027);
  WriteFileAtomically(folder / "x.txt", "x");
  ::umask(mask);
  struct stat status {};
  ASSERT_EQ(::stat((folder / "x.txt").c_str(), &status), 0);
  EXPECT_EQ(status.st_mode & 0777, 0640u);
}

// The header promises that a failing writer leaves the old file and no other.
TEST(WriteFileAtomically, LeavesTheOldFileWhereTheWriterThrows) {
  const TemporaryFolder folder;
  folder.Write("x.exr", "old");
  const auto fail = [](const std::filesystem::path& temporary) {
    std::ofstream(temporary) << "half of it";
    throw InputError("the writer's own");
  };
  EXPECT_EQ(SentenceOf<InputError>([&] { WriteFileAtomically(folder / "x.exr", fail); }), "the writer's own");
  EXPECT_EQ(Slurp(folder / "x.exr"), "old");
  EXPECT_THAT(folder.Names(), ElementsAre("x.exr"));
}

// Image libraries choose a format by the extension; ".NAME.partial-" hides the file from globs.
TEST(WriteFileAtomically, TemporaryNameIsBesideTheTargetAndKeepsItsExtension) {
  const TemporaryFolder folder;
  std::filesystem::path seen;
  WriteFileAtomically(folder / "x.exr", [&](const std::filesystem::path& temporary) {
    seen = temporary;
    std::ofstream(temporary) << "new";
  });
  EXPECT_EQ(seen.parent_path(), folder.path());
  EXPECT_EQ(seen.extension(), ".exr");
  EXPECT_THAT(seen.filename().string(), testing::StartsWith(".x.partial-"));
  EXPECT_EQ(Slurp(folder / "x.exr"), "new");
}

// setrlimit(2): a write past RLIMIT_FSIZE fails with EFBIG where SIGXFSZ is ignored.
TEST(WriteFileAtomically, ReportsAFullTargetAndLeavesNothingHalfWritten) {
  const TemporaryFolder folder;
  folder.Write("kept.bin", "old");
  const std::string large(100000, 'x');
  std::string sentence;
  {
    const FileSizeLimit limit(4096);
    sentence = SentenceOf<StorageError>([&] { WriteFileAtomically(folder / "kept.bin", large); });
  }
  EXPECT_THAT(sentence, HasSubstr("kept.bin"));
  EXPECT_THAT(sentence, HasSubstr("File too large"));
  EXPECT_THAT(sentence, HasSubstr("remedy"));
  EXPECT_EQ(Slurp(folder / "kept.bin"), "old");
  EXPECT_THAT(folder.Names(), ElementsAre("kept.bin"));
}

// As above; the second of two files does not fit, so neither may appear, nor the folder that was made for
// them.
TEST(FileBatch, LeavesNoneWhereOneDoesNotFit) {
  const TemporaryFolder folder;
  folder.Write("kept.txt", "old");
  const auto write_both = [&](std::size_t size) {
    FileBatch batch;
    WriteFileAtomically(folder / "kept.txt", "new");
    WriteFileAtomically(folder / "a/b/large.bin", std::string(size, 'x'));
    batch.Commit();
  };
  {
    const FileSizeLimit limit(4096);
    SentenceOf<StorageError>([&] { write_both(100000); });
  }
  EXPECT_THAT(folder.Names(), ElementsAre("kept.txt"));
  EXPECT_EQ(Slurp(folder / "kept.txt"), "old");
  write_both(100000);
  EXPECT_THAT(folder.Names(), testing::UnorderedElementsAre("kept.txt", "a", "a/b", "a/b/large.bin"));
  EXPECT_EQ(Slurp(folder / "kept.txt"), "new");
}

// The header: nothing has its name before Commit, and an inner batch is part of the outer one.
TEST(FileBatch, AppearsAtTheOuterCommit) {
  const TemporaryFolder folder;
  {
    FileBatch outer;
    {
      FileBatch inner;
      WriteFileAtomically(folder / "x.txt", "x");
      inner.Commit();
    }
    EXPECT_FALSE(std::filesystem::exists(folder / "x.txt"));
    outer.Commit();
    EXPECT_EQ(Slurp(folder / "x.txt"), "x");
  }
  WriteFileAtomically(folder / "y.txt", "y");
  EXPECT_EQ(Slurp(folder / "y.txt"), "y") << "after the batch, files go to their places at once";
}

// mkdir(2): ENOTDIR for a path that leads through a file.
TEST(WriteFileAtomically, NamesAPathThatLeadsThroughAFile) {
  const TemporaryFolder folder;
  folder.Write("file", "x");
  const std::string sentence =
      SentenceOf<StorageError>([&] { WriteFileAtomically(folder / "file/y.txt", "y"); });
  EXPECT_THAT(sentence, HasSubstr("file/y.txt"));
  EXPECT_THAT(sentence, HasSubstr("Not a directory"));
}

// A folder, and a device that rename(2) would replace, are no targets.
TEST(WriteFileAtomically, RefusesFoldersAndDevices) {
  const TemporaryFolder folder;
  EXPECT_THAT(SentenceOf<StorageError>([&] { WriteFileAtomically(folder.path(), "y"); }),
              HasSubstr("name a file, not a folder"));
  EXPECT_THAT(SentenceOf<StorageError>([] { WriteFileAtomically("/dev/full", "y"); }), HasSubstr("a device"));
  struct stat status {};
  ASSERT_EQ(::stat("/dev/full", &status), 0);
  EXPECT_TRUE(S_ISCHR(status.st_mode));
}

// open(2) follows links, and so must a replacement of it.
TEST(WriteFileAtomically, WritesThroughASymbolicLink) {
  const TemporaryFolder folder;
  folder.Write("deep/real.txt", "old");
  std::filesystem::create_symlink("deep/real.txt", folder / "link.txt");
  WriteFileAtomically(folder / "link.txt", "new");
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link.txt"));
  EXPECT_EQ(Slurp(folder / "deep/real.txt"), "new");
}

// FIPS 180-2, appendix B.1 ("abc") and B.2 (the 56-byte message); the empty message's digest is NIST's.
TEST(Sha256, MatchesThePublishedDigests) {
  const auto of = [](std::string_view text) {
    return Sha256(std::as_bytes(std::span(text.data(), text.size())));
  };
  EXPECT_EQ(of("abc"), "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad");
  EXPECT_EQ(of("abcdbcdecdefdefgefghfghighijhijkijkljklmklmnlmnomnopnopq"),
            "248d6a61d20638b8e5c026930c3e6039a33ce45964ff2167f6ecedd419db06c1");
  EXPECT_EQ(of(""), "e3b0c44298fc1c149afbf4c8996fb92427ae41e4649b934ca495991b7852b855");
  const TemporaryFolder folder;
  EXPECT_EQ(Sha256OfFile(folder.Write("abc", "abc")), of("abc"));
}

// Bytes in, bytes out; what cannot be read is named with the system's reason.
TEST(ReadFile, ReturnsAllBytesAndNamesWhatItCannotRead) {
  const TemporaryFolder folder;
  std::string bytes(700001, '\0');
  for (std::size_t i = 0; i < bytes.size(); ++i) bytes[i] = static_cast<char>(i * 7919 >> 3);
  const auto file = folder.Write("data.bin", bytes);
  EXPECT_EQ(ReadTextFile(file), bytes);
  const auto binary = ReadBinaryFile(file);
  ASSERT_EQ(binary.size(), bytes.size());
  EXPECT_EQ(std::memcmp(binary.data(), bytes.data(), bytes.size()), 0);
  const std::string missing = SentenceOf<InputError>([&] { ReadTextFile(folder / "none.toml"); });
  EXPECT_THAT(missing, HasSubstr("none.toml"));
  EXPECT_THAT(missing, HasSubstr("No such file"));
  EXPECT_THAT(SentenceOf<InputError>([&] { ReadBinaryFile(folder.path()); }), HasSubstr("it is a folder"));
  EXPECT_THAT(SentenceOf<InputError>([&] { CheckReadable("/dev/null"); }), HasSubstr("a device"));
}

}  // namespace
}  // namespace dermap
