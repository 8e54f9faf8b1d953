"""Answers a program's requests: a line of JSON each, of which one of `answers` is called by its name.

Libraries print what they like; it goes to standard error, and the program reads the answers alone.
"""
import json
import os
import resource
import sys
import time


def serve(answers):
    channel = os.fdopen(os.dup(1), "w")
    os.dup2(2, 1)
    for line in sys.stdin:
        name, arguments = json.loads(line)
        print(json.dumps(answers[name](**arguments)), file=channel, flush=True)


def processor_seconds():
    usage = resource.getrusage(resource.RUSAGE_SELF)
    return usage.ru_utime + usage.ru_stime


def timed(work):
    """What `work` returns, with the seconds and the processor's seconds that it took."""
    start, used = time.perf_counter(), processor_seconds()
    result = work()
    return result, {"seconds": time.perf_counter() - start, "processor_seconds": processor_seconds() - used}
