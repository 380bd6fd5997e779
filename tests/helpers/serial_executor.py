"""An executor without threads and processes."""

from concurrent.futures import Executor, Future


class InOrder(Executor):
    """Does what it is given at once, in this process."""

    def submit(self, function, /, *args, **kwargs):
        future = Future()
        try:
            future.set_result(function(*args, **kwargs))
        except Exception as error:
            future.set_exception(error)
        return future
