"""Pages of reports, made at once; in a run their sections and the page are two steps."""

import inspect

from pipelines.report.report import report_body, report_sections


def body_of(**contents):
    """The body of a page from arguments of `report_body` and `report_sections`."""
    of_body, of_sections = (
        {name: value for name, value in contents.items() if name in inspect.signature(call).parameters}
        for call in (report_body, report_sections)
    )
    assert contents.keys() == of_body.keys() | of_sections.keys()
    return report_body(sections=report_sections(**of_sections), **of_body)
