"""Runs a command with the catalogue of every data folder in PostgreSQL and its photos and maps in an S3 store: a server of
each for the command alone, in its environment as server_support reads it.

usage: both_stores.py [--swift] COMMAND...   answers its exit code; 77, which ctest shows as skipped, where one of the two is not
here. The store is s3rver, or with --swift OpenStack Swift, which takes a minute to start.
"""
import os
import pathlib
import subprocess
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1]))
sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "support"))
import s3_store
from cluster import swift_store
from postgres_server import LATE_WRITER, PostgresServer


def main():
    is_swift = sys.argv[1] == "--swift"
    command = sys.argv[2 if is_swift else 1:]
    if is_swift and (missing := swift_store.missing_programs()):
        print(f"skipped: Swift is not installed: {', '.join(missing)}")
        return 77
    try:
        database = PostgresServer(LATE_WRITER)
    except FileNotFoundError as none:
        print(f"skipped: {none}")
        return 77
    with database:
        try:
            store = swift_store.SwiftStore() if is_swift else s3_store.S3Store()
        except s3_store.NoStore as none:
            print(f"skipped: {none}")
            return 77
        try:
            where = {"SKYQUILT_TEST_POSTGRES": database.url, "SKYQUILT_TEST_BLOBS": store.address(), **store.environment()}
            if not is_swift:
                where["SKYQUILT_TEST_BLOBS_FOLDER"] = str(store.bucket)
            return subprocess.run(command, env={**os.environ, **where}).returncode
        finally:
            store.stop()


if __name__ == "__main__":
    sys.exit(main())
